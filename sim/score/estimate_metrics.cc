#include <cmath>

#include "sim/score/metrics.h"
#include "sim/score/run.h"

namespace sim::score {
namespace {

using enum Worst;
using C = const ScoreContext&;
using Numbers = std::vector<double>;

Value ate(const std::vector<PosePair>& pairs, Alignment alignment) {
  return value_of(align(pairs, alignment), [&](const Similarity& S) -> Value {
    return root_mean_square(position_errors(transformed(S, pairs)));
  });
}

MetricDefinition ate_metric(const std::string& name, const std::string& alignment, Needs needs, Alignment how,
                            bool headline = false) {
  return {"ate_" + name + "_rmse_m",
          "m",
          "Absolute trajectory error: root mean square distance between estimated and true camera positions, "
          "the estimate aligned by " +
              alignment + ". Frames count from the first planned motion on.",
          needs,
          [how](C c) { return ate(c.pairs, how); },
          largest,
          headline};
}

Value odometry_ate(C c) {
  if (c.run.odometry.empty()) return Absent{"odometry without images did not run beside the estimator"};
  return ate(pair_by_stamp(c.truth_camera, c.run.odometry), Alignment::se3);
}

Value scale_error(C c) {
  return value_of(align(c.pairs, Alignment::sim3),
                  [](const Similarity& S) -> Value { return 100 * (1 / S.scale - 1); });
}

double end_distance(C c) { return position_errors({c.pairs.back()}).front(); }

Value drift_percent(C c) {
  const double walked = path_length(c.truth_camera);
  if (walked <= 0) return Absent{"the true camera never moves"};
  return 100 * end_distance(c) / walked;
}

// The root mean square over 1 m of the true path of error(difference of the two motions).
MetricDefinition rpe_metric(const std::string& unit, const std::string& kind, Needs needs,
                            double (*error)(const Eigen::Isometry3d&)) {
  return {"rpe_1m_" + unit,
          unit,
          "Relative pose error: root mean square " + kind +
              " error of the motion over 1 m of the true path, from each frame to the one nearest to that "
              "distance, within 10 %.",
          needs,
          [error](C c) -> Value {
            Numbers errors;
            for (const Span& span : spans(c.pairs, {Spans::Unit::meters, 1, true, 0.1, true}))
              errors.push_back(error(relative_difference(c.pairs, span)));
            if (errors.empty()) return Absent{"the true path has no such spans"};
            return root_mean_square(errors);
          },
          largest,
          kHeadline};
}

MetricDefinition nees_metric(const std::string& name, double PoseNees::*part, Needs needs) {
  return {"nees_" + name + "_mean",
          "1",
          "Mean of the normalized estimation error squared (NEES) of the camera's " + name +
              ", without alignment, from the first planned motion on; 3 is expected.",
          needs,
          [part](C c) {
            return value_of(c.nees, [part](const std::vector<PoseNees>& all) -> Value {
              Numbers squares;
              for (const PoseNees& nees : all) squares.push_back(nees.*part);
              return mean(squares);
            });
          },
          Direction::away_from(3),
          kHeadline};
}

MetricDefinition nis_metric(std::size_t sensor) {
  const std::string name(kSensors[sensor]);
  return {"nis_" + name + "_mean",
          "1",
          "Mean normalized innovation squared (NIS) of the sensor " + name +
              " by its degrees of freedom, from the first planned motion on; 1 is expected.",
          Needs::estimate,
          [sensor](C c) -> Value {
            int frames = 0;
            double squares = 0, dof = 0;
            for (const StampedInnovation& innovation : c.run.innovations[sensor]) {
              if (innovation.t < *c.start || innovation.dof <= 0) continue;
              ++frames;
              squares += innovation.square;
              dof += innovation.dof;
            }
            if (frames < 2) return Absent{"the sensor was used in fewer than two frames"};
            return squares / dof;
          },
          Direction::away_from(1)};
}

MetricDefinition lag1_metric(std::size_t sensor) {
  const std::string name(kSensors[sensor]);
  return {"innovation_lag1_" + name,
          "1",
          "Correlation of the normalized innovations of the sensor " + name +
              " from frame to frame, from the first planned motion on; 0 if they are white.",
          Needs::estimate,
          [sensor](C c) -> Value {  // Bar-Shalom et al. 2001, eq. 5.4.2-8 with lag 1
            double products = 0, squares = 0;
            for (const StampedInnovation& innovation : c.run.innovations[sensor]) {
              if (innovation.t < *c.start) continue;
              products += innovation.lagged, squares += innovation.lagged_square;
            }
            if (squares <= 0) return Absent{"no innovations of consecutive frames were reported"};
            return products / squares;
          },
          largest_magnitude};
}

// The fraction of the answers from the first planned motion on with readings of a sensor, or, of those with
// readings, with accepted ones.
Value fraction_in_use(C c, std::size_t sensor, bool of_accepted) {
  if (c.run.use.empty()) return Absent{"the estimator does not report which sensors it uses"};
  double all = 0, with_readings = 0, accepted = 0;
  for (const FrameUse& frame : c.run.use) {
    if (frame.t < *c.start) continue;
    ++all, with_readings += frame.readings[sensor], accepted += frame.accepted[sensor];
  }
  if (with_readings == 0 && of_accepted) return Absent{"the filter had no readings of the sensor"};
  return of_accepted ? accepted / with_readings : with_readings / all;
}

void add_use(MetricDefinitions& all, std::size_t sensor) {
  const std::string name(kUsedSensors[sensor]);
  all.push_back({"readings_" + name + "_fraction", "1",
                 "Fraction of the frames in which the filter had readings of the sensor " + name +
                     ", from the first planned motion on.",
                 Needs::estimate, [sensor](C c) { return fraction_in_use(c, sensor, false); }, smallest});
  all.push_back({"accepted_" + name + "_fraction", "1",
                 "Fraction of the frames with readings of the sensor " + name +
                     " in which they passed its gate and were used.",
                 Needs::estimate, [sensor](C c) { return fraction_in_use(c, sensor, true); }, smallest});
}

Value landmark_rmse(C c) {
  Numbers distances;
  for (const LandmarkError& error : landmark_errors(c.run)) distances.push_back(error.distance);
  if (distances.empty()) return Absent{"the final map has no landmark with a known surface point"};
  return root_mean_square(distances);
}

}  // namespace

MetricDefinitions estimate_metrics() {
  return {
      ate_metric("se3", "the rotation and translation of least squares (SE(3))", Needs::scale, Alignment::se3,
                 kHeadline),
      {"rmse_m", "m",
       "Root mean square distance between estimated and true camera positions, without alignment: both are "
       "in W, the plan's world at t = 0. Frames count from the first planned motion on, when the planned "
       "waist is more than 1 mm from its start.",
       Needs::scale, [](C c) { return ate(c.pairs, Alignment::none); }, largest, kHeadline},
      ate_metric("yaw", "the rotation about the vertical and the translation of least squares", Needs::scale,
                 Alignment::yaw_position),
      ate_metric("sim3", "the rotation, translation and scale of least squares (Sim(3))", Needs::estimate,
                 Alignment::sim3),
      {"scale_error_percent", "%",
       "Excess length of the estimated path, by the scale of the alignment of ate_sim3_rmse_m.", Needs::scale,
       scale_error, largest_magnitude, kHeadline},
      {"odometry_ate_se3_rmse_m", "m",
       "ate_se3_rmse_m of the same sensors without images (estimator: odometry), which runs beside any other "
       "estimator: what images add.",
       Needs::walk, odometry_ate},
      {"poses_matched", "1",
       "Number of estimated poses that have the stamp of a true one, within 0.1 ms, from the first planned "
       "motion on: the errors are taken over these.",
       Needs::estimate, [](C c) { return static_cast<double>(c.pairs.size()); }, smallest},
      {"true_poses", "1",
       "Number of true poses from the first planned motion on. poses_matched of them have an estimate.",
       Needs::walk,
       [](C c) -> Value {
         if (c.truth_camera.empty()) return Absent{"the plan never moves"};
         return static_cast<double>(c.truth_camera.size());
       },
       smallest},
      {"rotation_rmse_deg", "deg",
       "Root mean square angle between estimated and true camera orientations, without alignment, from the "
       "first planned motion on.",
       Needs::estimate, [](C c) { return root_mean_square(orientation_errors(c.pairs)) / kDegree; }},
      rpe_metric("m", "translation", Needs::scale,
                 [](const Eigen::Isometry3d& E) { return E.translation().norm(); }),
      rpe_metric("deg", "rotation", Needs::estimate,
                 [](const Eigen::Isometry3d& E) { return rotation_vector(E.linear()).norm() / kDegree; }),
      {"end_position_error_m", "m",
       "Distance between estimated and true camera positions at the last frame with an estimate, without "
       "alignment.",
       Needs::scale, end_distance, largest, kHeadline, kAtEnd},
      {"drift_percent", "%", "end_position_error_m in percent of path_length_m.", Needs::scale, drift_percent,
       largest, kHeadline, kAtEnd},
      {"end_yaw_error_deg", "deg",
       "Magnitude of the rotation about the vertical from the estimated to the true camera orientation at "
       "the last frame with an estimate, without alignment.",
       Needs::estimate, [](C c) { return std::abs(yaw_error(c.pairs.back())) / kDegree; }, largest, kHeadline,
       kAtEnd}};
}

MetricDefinitions consistency_metrics() {
  MetricDefinitions all{
      {"poses_with_covariance", "1",
       "Number of matched poses with a covariance: the NEES is taken over these.", Needs::estimate,
       [](C c) {
         return value_of(c.nees, [](const std::vector<PoseNees>& nees) -> Value {
           return static_cast<double>(nees.size());
         });
       },
       smallest},
      nees_metric("position", &PoseNees::position, Needs::scale),
      nees_metric("orientation", &PoseNees::orientation, Needs::estimate)};
  for (std::size_t sensor = 0; sensor < kSensors.size(); ++sensor) all.push_back(nis_metric(sensor));
  for (std::size_t sensor = 0; sensor < kSensors.size(); ++sensor) all.push_back(lag1_metric(sensor));
  for (std::size_t sensor = 0; sensor < kUsedSensors.size(); ++sensor) add_use(all, sensor);
  all.push_back({"landmark_rmse_m", "m",
                 "Root mean square distance of the final map's landmarks from the point at which the ray "
                 "through their first pixel, from the true camera, meets the room.",
                 Needs::scale, landmark_rmse});
  return all;
}

}  // namespace sim::score
