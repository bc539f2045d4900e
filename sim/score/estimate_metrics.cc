#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/score/alignment.h"
#include "sim/score/metrics.h"
#include "sim/score/relative.h"
#include "sim/score/score_context.h"

namespace sim::score {
namespace {

using enum Worst;
using C = const ScoreContext&;
using Numbers = std::vector<double>;

Value ate(C c, Alignment alignment) {
  const auto found = align(c.pairs, alignment);
  if (const auto* absent = std::get_if<Absent>(&found)) return *absent;
  return root_mean_square(position_errors(transformed(std::get<Similarity>(found), c.pairs)));
}

Value scale_error(C c) {
  const auto found = align(c.pairs, Alignment::sim3);
  if (const auto* absent = std::get_if<Absent>(&found)) return *absent;
  return 100 * (1 / std::get<Similarity>(found).scale - 1);
}

double end_distance(C c) { return position_errors({c.pairs.back()}).front(); }

Value drift_percent(C c) {
  const double walked = path_length(c.truth_camera);
  if (walked <= 0) return Absent{"the true camera never moves"};
  return 100 * end_distance(c) / walked;
}

MetricDefinition ate_metric(const std::string& name, const std::string& alignment, Needs needs, Alignment how,
                            bool headline = false) {
  return {"ate_" + name + "_rmse_m",
          "m",
          "Absolute trajectory error: root mean square distance between estimated and true camera positions, "
          "the estimate aligned by " +
              alignment + ". Frames count from the first planned motion on.",
          needs,
          [how](C c) { return ate(c, how); },
          largest,
          headline};
}

// The root mean square over 1 m of the true path of error(difference of the two motions).
template <typename Error>
Value rpe_over_1m(C c, Error error) {
  Numbers errors;
  for (const Span& span : spans(c.pairs, {Spans::Unit::meters, 1, true, 0.1, true}))
    errors.push_back(error(relative_difference(c.pairs, span)));
  if (errors.empty()) return Absent{"the true path has no such spans"};
  return root_mean_square(errors);
}

// of(the NEES of all frames)
template <typename F>
auto of_nees(double PoseNees::*part, F of) {
  return [part, of](C c) -> Value {
    if (const auto* absent = std::get_if<Absent>(&c.nees)) return *absent;
    Numbers squares;
    for (const PoseNees& nees : std::get<std::vector<PoseNees>>(c.nees)) squares.push_back(nees.*part);
    return of(squares);
  };
}

Value variance(const Numbers& squares) {
  if (squares.size() < 2) return Absent{"one frame has no variance"};
  const double sd = standard_deviation(squares);
  return sd * sd;
}

double fraction_within_95(const Numbers& squares) {
  const double most = chi_square_quantile(0.95, 3);
  const auto within =
      std::count_if(squares.begin(), squares.end(), [most](double square) { return square <= most; });
  return static_cast<double>(within) / static_cast<double>(squares.size());
}

void add_nees(MetricDefinitions& all, const std::string& name, double PoseNees::*part, Needs needs) {
  const std::string of = "normalized estimation error squared (NEES) of the camera's " + name +
                         ", without alignment, from the first planned motion on";
  all.push_back({"nees_" + name + "_mean", "1", "Mean of the " + of + "; 3 is expected.", needs,
                 of_nees(part, mean), Direction::away_from(3), kHeadline});
  all.push_back({"nees_" + name + "_variance", "1", "Variance of the " + of + "; 6 is expected.", needs,
                 of_nees(part, variance), Direction::away_from(6)});
  all.push_back({"nees_" + name + "_within_95", "1",
                 "Fraction of the frames in which the " + of +
                     ", is at most 7.81, the 95 % quantile of a chi-square of 3 degrees of freedom; 0.95 is "
                     "expected.",
                 needs, of_nees(part, fraction_within_95), Direction::away_from(0.95)});
}

// of(the summary of a sensor's innovations)
template <typename F>
auto of_innovations(std::size_t sensor, F of) {
  return [sensor, of](C c) -> Value {
    std::vector<Innovation> all;
    for (const StampedInnovation& innovation : c.run.innovations[sensor])
      if (innovation.t >= *c.start) all.push_back(innovation.innovation);
    const auto summary = summarize(all);
    if (!summary) return Absent{"the sensor was used in fewer than two frames"};
    return of(*summary);
  };
}

void add_nis(MetricDefinitions& all, std::size_t sensor) {
  const std::string name(kSensors[sensor]), nis = "normalized innovation squared (NIS) of the sensor " + name;
  all.push_back(
      {"nis_" + name + "_mean", "1",
       "Mean " + nis + " by its degrees of freedom, from the first planned motion on; 1 is expected.",
       Needs::estimate, of_innovations(sensor, [](const InnovationSummary& i) { return i.ratio; }),
       Direction::away_from(1)});
  all.push_back({"nis_" + name + "_variance", "1",
                 "Variance of the " + nis + " divided by that of its chi-square distribution; 1 is expected.",
                 Needs::estimate,
                 of_innovations(sensor, [](const InnovationSummary& i) { return i.variance_ratio; }),
                 Direction::away_from(1)});
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

// of(the errors of the final map's landmarks)
template <typename F>
auto of_landmarks(F of) {
  return [of](C c) -> Value {
    const auto errors =
        landmark_errors(c.run.map, c.run.landmarks, c.run.truth_camera, c.run.surfaces, c.run.camera);
    if (errors.empty()) return Absent{"the final map has no landmark with a known surface point"};
    return of(errors);
  };
}

double landmark_rmse(const std::vector<LandmarkError>& errors) {
  Numbers distances;
  for (const LandmarkError& error : errors) distances.push_back(error.distance);
  return root_mean_square(distances);
}

Value landmark_nees(const std::vector<LandmarkError>& errors) {
  Numbers squares;
  for (const LandmarkError& error : errors)
    if (error.nees) squares.push_back(*error.nees);
  if (squares.size() != errors.size()) return Absent{"a landmark's covariance is not positive definite"};
  return mean(squares);
}

}  // namespace

MetricDefinitions absolute_metrics() {
  return {
      ate_metric("se3", "the rotation and translation of least squares (SE(3))", Needs::scale, Alignment::se3,
                 kHeadline),
      {"rmse_m", "m",
       "Root mean square distance between estimated and true camera positions, without alignment: both are "
       "in W, the plan's world at t = 0. Frames count from the first planned motion on, when the planned "
       "waist is more than 1 mm from its start.",
       Needs::scale, [](C c) { return ate(c, Alignment::none); }, largest, kHeadline},
      ate_metric("yaw", "the rotation about the vertical and the translation of least squares", Needs::scale,
                 Alignment::yaw_position),
      ate_metric("sim3", "the rotation, translation and scale of least squares (Sim(3))", Needs::estimate,
                 Alignment::sim3),
      {"scale_error_percent", "%",
       "Excess length of the estimated path, by the scale of the alignment of ate_sim3_rmse_m.", Needs::scale,
       scale_error, largest_magnitude, kHeadline},
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
       Needs::estimate, [](C c) { return root_mean_square(orientation_errors(c.pairs)) / kDegree; }}};
}

MetricDefinitions relative_metrics() {
  const std::string text = "Relative pose error: root mean square ",
                    over =
                        " error of the motion over 1 m of the true path, from each frame to the one nearest "
                        "to that distance, within 10 %.";
  const auto translation = [](const Eigen::Isometry3d& E) { return E.translation().norm(); };
  const auto rotation = [](const Eigen::Isometry3d& E) {
    return rotation_vector(E.linear()).norm() / kDegree;
  };
  return {{"rpe_1m_m", "m", text + "translation" + over, Needs::scale,
           [translation](C c) { return rpe_over_1m(c, translation); }, largest, kHeadline},
          {"rpe_1m_deg", "deg", text + "rotation" + over, Needs::estimate,
           [rotation](C c) { return rpe_over_1m(c, rotation); }, largest, kHeadline}};
}

MetricDefinitions end_metrics() {
  return {
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
  MetricDefinitions all;
  all.push_back({"poses_with_covariance", "1",
                 "Number of matched poses with a covariance: the NEES is taken over these.", Needs::estimate,
                 [](C c) -> Value {
                   if (const auto* absent = std::get_if<Absent>(&c.nees)) return *absent;
                   return static_cast<double>(std::get<std::vector<PoseNees>>(c.nees).size());
                 },
                 smallest});
  add_nees(all, "position", &PoseNees::position, Needs::scale);
  add_nees(all, "orientation", &PoseNees::orientation, Needs::estimate);
  for (std::size_t sensor = 0; sensor < kSensors.size(); ++sensor) add_nis(all, sensor);
  for (std::size_t sensor = 0; sensor < kUsedSensors.size(); ++sensor) add_use(all, sensor);
  return all;
}

MetricDefinitions landmark_metrics() {
  return {{"landmark_rmse_m", "m",
           "Root mean square distance of the final map's landmarks from the point at which the ray through "
           "their first pixel, from the true camera, meets the room.",
           Needs::scale, of_landmarks(landmark_rmse)},
          {"landmark_nees_mean", "1",
           "Mean of the squared errors of landmark_rmse_m, normalized by the landmarks' covariances; 3 is "
           "expected.",
           Needs::scale, of_landmarks(landmark_nees), Direction::away_from(3)}};
}

}  // namespace sim::score
