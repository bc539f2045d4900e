#include "sim/score/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/score/run.h"

namespace sim::score {
namespace {

constexpr double kFirstMotion_m = 0.001;

/// Prefixes of the names of metrics that compare orientations or unaligned poses.
constexpr std::array kOfPoses{"rmse_m", "rotation_",   "rpe_",  "smoothed_rmse_m", "smoothed_rotation_",
                              "end_",   "drift_",      "nees_", "poses_with",      "landmark_",
                              "plan_",  "true_height_"};

std::optional<Stamp> first_motion(const Run& run) {
  if (run.plan_waist.empty() && !run.truth_camera.empty()) return run.truth_camera.front().t;
  for (const TimedPose& pose : run.plan_waist)
    if ((pose.X.translation() - run.plan_waist.front().X.translation()).norm() > kFirstMotion_m)
      return pose.t;
  return std::nullopt;
}

std::optional<Absent> why_no_estimate(const ScoreContext& c) {
  if (!c.run.estimate) return Absent{"the estimator was not run"};
  if (c.run.failed) return Absent{"the estimator failed: " + *c.run.failed};
  if (c.run.diverged) return Absent{"the estimator diverged: " + *c.run.diverged};
  if (!c.start) return Absent{c.run.plan_waist.empty() ? "the run has no true pose" : "the plan never moves"};
  if (c.run.estimate->empty()) return Absent{"the estimator never tracked"};
  if (c.pairs.empty()) return Absent{"no estimate has the stamp of a true pose"};
  return std::nullopt;
}

OrAbsent<std::vector<PoseNees>> nees_of(const std::vector<PosePair>& pairs, const Run& run) {
  std::vector<PoseNees> all;
  if (pairs.empty()) return all;
  const Similarity S = std::get<Similarity>(align(pairs, run.fitted ? Alignment::origin : Alignment::none));
  Matrix6d J = Matrix6d::Identity();
  J.bottomRightCorner<3, 3>() = S.R;
  auto pose = run.estimate->begin();
  for (const PosePair& pair : transformed(S, pairs)) {
    while (pose->t != pair.t) ++pose;
    if (!pose->covariance) continue;
    const auto nees = pose_nees(pair.X_true, pair.X_estimate, J * *pose->covariance * J.transpose());
    if (!nees) return Absent{"a covariance of the estimate is not positive definite"};
    all.push_back(*nees);
  }
  if (all.empty()) return Absent{"the estimator states no covariance"};
  return all;
}

OrAbsent<std::vector<LoopLandmark>> loop_of(const ScoreContext& c) {
  if (c.no_estimate) return *c.no_estimate;
  if (c.run.no_matches) return Absent{*c.run.no_matches};
  return loop_landmarks(c.run);
}

// Returns "at 3.4 s, 8 % of 43.0 s" if the last moment is not the end of the plan and of the truth.
std::optional<std::string> note_of_end(const MetricDefinition& definition, const ScoreContext& context) {
  const Trajectory &camera = context.run.truth_camera, &waist = context.run.truth_waist;
  const bool of_walk = definition.needs == Needs::walk;
  if (camera.size() < 2 || (of_walk ? waist.empty() : context.pairs.empty())) return std::nullopt;
  const Stamp last = of_walk ? waist.back().t : context.pairs.back().t, interval = camera[1].t - camera[0].t,
              end = std::max(context.run.plan_end.value_or(Stamp(0)), camera.back().t);
  if (last + 2 * interval >= end || last >= end / 100 * 99) return std::nullopt;
  const double last_s = 1e-9 * double(last.count()), end_s = 1e-9 * double(end.count());
  return fmt::format("at {:.1f} s, {:.0f} % of {:.1f} s", last_s, 100 * last_s / end_s, end_s);
}

// The pairs as the estimator gave them, if its path was scaled to the truth.
std::vector<PosePair> unscaled(const ScoreContext& context) {
  std::vector<PosePair> pairs = context.pairs;
  for (PosePair& pair : pairs) pair.X_estimate.translation() /= context.run.scaled_by;
  return pairs;
}

std::optional<std::string> note_of(const MetricDefinition& definition, const ScoreContext& context) {
  if (definition.note == Note::none) return std::nullopt;
  if (definition.note == Note::at_end) return note_of_end(definition, context);
  const std::size_t matched = context.pairs.size(), all = context.truth_camera.size();
  std::string note = matched * 100 < all * 99 ? fmt::format("{} of {} true poses", matched, all) : "";
  if (definition.note == Note::scale) {
    Similarity S = std::get<Similarity>(align(context.pairs, Alignment::sim3));
    S.scale *= context.run.scaled_by;
    const auto doubt = doubt_of_scale(S, unscaled(context));
    note += fmt::format("{}scale {:.4g}{}", note.empty() ? "" : ", ", S.scale,
                        doubt ? "; warning: " + *doubt : "");
  }
  return note.empty() ? std::nullopt : std::optional(note);
}

Metric compute(const MetricDefinition& definition, const ScoreContext& context) {
  const auto absent = [&](const std::string& reason) {
    return Metric{std::nullopt, definition.unit, reason};
  };
  const auto starts_name = [&](const char* beginning) { return definition.name.starts_with(beginning); };
  if (!context.run.truth_has_poses && std::ranges::any_of(kOfPoses, starts_name))
    return absent("the truth has only positions: see the errors after alignment, ate_...");
  if (definition.needs == Needs::scale && context.run.no_scale) return absent(*context.run.no_scale);
  if (definition.needs != Needs::walk && context.no_estimate) return absent(context.no_estimate->reason);
  const Value found = definition.compute(context);
  if (const auto* const none = std::get_if<Absent>(&found)) return absent(none->reason);
  const double number = std::get<double>(found);
  if (!std::isfinite(number)) return absent("the value is not finite");
  return {number, definition.unit, "", note_of(definition, context)};
}

// Metrics of the estimate.

using enum Worst;
using C = const ScoreContext&;
using Numbers = std::vector<double>;

Value ate(const std::vector<PosePair>& pairs, Alignment alignment) {
  return value_of(align(pairs, alignment), [&](const Similarity& S) -> Value {
    return root_mean_square(position_errors(transformed(S, pairs)));
  });
}

MetricDefinition ate_metric(const std::string& name, const std::string& alignment, Alignment how,
                            bool headline = kHeadline, Note note = Note::coverage) {
  return {"ate_" + name + "_rmse_m",
          "m",
          "Absolute trajectory error: root mean square distance between estimated and true camera positions, "
          "the estimate aligned by " +
              alignment + ". Frames count from the first planned motion.",
          Needs::estimate,
          [how](C c) -> Value {
            if (how == Alignment::sim3) return ate(c.pairs, how);
            if (c.run.no_scale && !c.run.fitted) return Absent{*c.run.no_scale};
            return ate(unscaled(c), how);
          },
          largest,
          headline,
          note};
}

Value odometry_ate(C c) {
  if (c.run.odometry.empty()) return Absent{"odometry without images did not run along with the estimator"};
  return ate(pair_by_stamp(c.truth_camera, c.run.odometry), Alignment::se3);
}

// Applies `of` to the pairs of true and smoothed poses; the definition refers to the estimate's metric.
MetricDefinition smoothed_metric(const std::string& name, const std::string& unit,
                                 Value (*of)(const std::vector<PosePair>&)) {
  return {
      "smoothed_" + name, unit,
      "Value of " + name + " for the smoothed estimate: each pose given the observations of the whole run.",
      Needs::scale, [of](C c) -> Value {
        if (c.run.smoothed.empty())
          return Absent{
              "nothing was smoothed: only the built-in filter smooths, with images and with space "
              "for its temporary file"};
        return of(pair_by_stamp(c.truth_camera, c.run.smoothed));
      }};
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

// Root mean square of error(X), where X is the difference between the two motions over 1 m of the true path.
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
          kHeadline,
          Note::coverage};
}

MetricDefinition nees_metric(const std::string& name, double PoseNees::*part, Needs needs) {
  return {
      "nees_" + name + "_mean",
      "1",
      "Mean of the normalized estimation error squared (NEES) of the camera's " + name +
          ", from the first planned motion; 3 is expected for the mean over ten or more seeds, and 1.0 to "
          "5.8 for one run of a consistent filter. Without alignment, or aligned by the first pose if the "
          "estimate was fitted to the truth.",
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
              " per degree of freedom, from the first planned motion; 1 is expected.",
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
              " from frame to frame, from the first planned motion; 0 if they are white.",
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

// The fraction of the answers since the first planned motion that have readings of a sensor, or the fraction
// of these with accepted readings.
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

Value found_fraction(C c) {
  double searched = 0, found = 0;
  for (const FrameUse& frame : c.run.use)
    if (frame.t >= *c.start) searched += double(frame.searched), found += double(frame.found);
  return searched > 0 ? Value(found / searched) : Value(Absent{"the estimator searched for no landmark"});
}

void add_use(MetricDefinitions& all, std::size_t sensor) {
  const std::string name(kUsedSensors[sensor]);
  all.push_back(
      {"readings_" + name + "_fraction", "1",
       "Fraction of the frames with readings of the sensor " + name + ", from the first planned motion.",
       Needs::estimate, [sensor](C c) { return fraction_in_use(c, sensor, false); }, smallest});
  all.push_back(
      {"accepted_" + name + "_fraction", "1",
       "Fraction of the frames with readings of the sensor " + name + " that passed its gate and were used.",
       Needs::estimate, [sensor](C c) { return fraction_in_use(c, sensor, true); }, smallest});
}

Value landmark_rmse(C c) {
  const Numbers distances = landmark_errors(c.run);
  if (distances.empty()) return Absent{"the final map has no landmark with a known surface point"};
  return root_mean_square(distances);
}

constexpr const char* kNothingMoves = "nothing moves in the room (world.actors)";

Value moving_image(C c) {
  constexpr std::size_t kEvery = 10;  // frames: several a second
  if (!c.run.actors) return Absent{kNothingMoves};
  if (c.truth_camera.empty() || c.run.camera.grid.empty()) return Absent{"the run has no images"};
  Numbers fractions;
  for (std::size_t i = 0; i < c.truth_camera.size(); i += kEvery)
    fractions.push_back(moving_fraction(c.run, c.truth_camera[i].X, c.truth_camera[i].t));
  return mean(fractions);
}

Value moving_landmarks(C c) {
  if (!c.run.actors) return Absent{kNothingMoves};
  if (c.run.no_matches) return Absent{*c.run.no_matches};
  const auto fraction = moving_landmarks_fraction(c.run);
  return fraction ? Value(*fraction) : Value(Absent{"no landmark was seen"});
}

// Errors over all frames, relative errors, and errors at the last frame.
MetricDefinitions estimate_metrics() {
  return {
      ate_metric("se3", "the rotation and translation of least squares (SE(3))", Alignment::se3),
      {"rmse_m", "m",
       "Root mean square distance between estimated and true camera positions, without alignment: both are "
       "in W, the plan's world at t = 0. Frames count from the first planned motion, when the planned "
       "waist is more than 1 mm from its start.",
       Needs::scale, [](C c) { return ate(c.pairs, Alignment::none); }, largest, kHeadline, Note::coverage},
      ate_metric("yaw", "the rotation about the vertical and the translation of least squares",
                 Alignment::yaw_position, false),
      ate_metric("sim3", "the rotation, translation and scale of least squares (Sim(3))", Alignment::sim3,
                 kHeadline, Note::scale),
      {"scale_error_percent", "%",
       "Excess length of the estimated path, by the scale of the alignment of ate_sim3_rmse_m.", Needs::scale,
       scale_error, largest_magnitude, kHeadline},
      {"odometry_ate_se3_rmse_m", "m",
       "ate_se3_rmse_m of the same sensors without images (estimator: odometry), which runs along with any "
       "other estimator: shows the benefit of images.",
       Needs::walk, odometry_ate},
      smoothed_metric("ate_se3_rmse_m", "m",
                      [](const std::vector<PosePair>& pairs) { return ate(pairs, Alignment::se3); }),
      smoothed_metric("rmse_m", "m",
                      [](const std::vector<PosePair>& pairs) { return ate(pairs, Alignment::none); }),
      smoothed_metric("rotation_rmse_deg", "deg",
                      [](const std::vector<PosePair>& pairs) -> Value {
                        return root_mean_square(orientation_errors(pairs)) / kDegree;
                      }),
      {"poses_matched", "1",
       "Number of estimated poses whose stamp is within 0.1 ms of a true pose's, from the first planned "
       "motion: the errors are computed from these.",
       Needs::estimate, [](C c) { return double(c.pairs.size()); }, smallest},
      {"true_poses", "1",
       "Number of true poses from the first planned motion, of which poses_matched have an estimate.",
       Needs::walk,
       [](C c) -> Value {
         if (c.truth_camera.empty()) return Absent{"the plan never moves"};
         return double(c.truth_camera.size());
       },
       smallest},
      {"rotation_rmse_deg", "deg",
       "Root mean square angle between estimated and true camera orientations, without alignment, from the "
       "first planned motion.",
       Needs::estimate, [](C c) { return root_mean_square(orientation_errors(c.pairs)) / kDegree; }, largest,
       false, Note::coverage},
      rpe_metric("m", "translation", Needs::scale,
                 [](const Eigen::Isometry3d& E) { return E.translation().norm(); }),
      rpe_metric("deg", "rotation", Needs::estimate,
                 [](const Eigen::Isometry3d& E) { return rotation_vector(E.linear()).norm() / kDegree; }),
      {"end_position_error_m", "m",
       "Distance between estimated and true camera positions at the last frame with an estimate, without "
       "alignment.",
       Needs::scale, end_distance, largest, kHeadline, Note::at_end},
      {"drift_percent", "%", "end_position_error_m in percent of path_length_m.", Needs::scale, drift_percent,
       largest, kHeadline, Note::at_end},
      {"end_yaw_error_deg", "deg",
       "Magnitude of the rotation about the vertical from the estimated to the true camera orientation at "
       "the last frame with an estimate, without alignment.",
       Needs::estimate, [](C c) { return std::abs(yaw_error(c.pairs.back())) / kDegree; }, largest, kHeadline,
       Note::at_end}};
}

// NEES, NIS and use of each sensor, and the map's landmarks.
MetricDefinitions consistency_metrics() {
  MetricDefinitions all{
      {"poses_with_covariance", "1",
       "Number of matched poses with a covariance: the NEES is computed from these.", Needs::estimate,
       [](C c) {
         return value_of(c.nees,
                         [](const std::vector<PoseNees>& nees) -> Value { return double(nees.size()); });
       },
       smallest},
      nees_metric("position", &PoseNees::position, Needs::scale),
      nees_metric("orientation", &PoseNees::orientation, Needs::estimate)};
  for (std::size_t sensor = 0; sensor < kSensors.size(); ++sensor) all.push_back(nis_metric(sensor));
  for (std::size_t sensor = 0; sensor < kSensors.size(); ++sensor) all.push_back(lag1_metric(sensor));
  for (std::size_t sensor = 0; sensor < kUsedSensors.size(); ++sensor) add_use(all, sensor);
  all.push_back({"found_landmarks_fraction", "1",
                 "Fraction of the searches for landmarks that succeeded, from the first planned motion.",
                 Needs::estimate, found_fraction, smallest});
  all.push_back({"landmark_rmse_m", "m",
                 "Root mean square distance of the final map's landmarks from the first surface point on the "
                 "ray through their first pixel, from the true camera.",
                 Needs::scale, landmark_rmse});
  all.push_back({"moving_image_fraction", "1",
                 "Share of people and doors that move in the true camera's images, mean of every tenth frame "
                 "from the first planned motion.",
                 Needs::walk, moving_image, largest});
  all.push_back({"moving_landmarks_fraction", "1",
                 "Fraction of the estimator's landmarks that were first seen on a person or door that moves.",
                 Needs::estimate, moving_landmarks, largest});
  return all;
}

}  // namespace

ScoreContext::ScoreContext(const Run& run_) : run(run_), start(first_motion(run_)) {
  if (start)
    for (const TimedPose& pose : run.truth_camera)
      if (pose.t >= *start) truth_camera.push_back(pose);
  if (start && run.estimate)
    for (const files::TumRow& pose : *run.estimate)
      if (pose.t >= *start) estimate.push_back(pose);
  pairs = pair_by_stamp(truth_camera, estimate);
  nees = nees_of(pairs, run);
  no_estimate = why_no_estimate(*this);
  loop = loop_of(*this);
}

const MetricDefinitions& metric_definitions() {
  static const MetricDefinitions definitions = [] {
    MetricDefinitions all;
    for (const auto group : {estimate_metrics, walk_metrics, loop_metrics, consistency_metrics,
                             completion_metrics, map_metrics, timeliness_metrics})
      for (MetricDefinition& definition : group()) all.push_back(std::move(definition));
    return all;
  }();
  return definitions;
}

const MetricDefinition* find_metric(std::string_view name) {
  const auto& all = metric_definitions();
  const auto found = std::ranges::find(all, name, &MetricDefinition::name);
  return found == all.end() ? nullptr : &*found;
}

Direction direction_of(std::string_view name) {
  const MetricDefinition* defined = find_metric(name);
  return defined ? defined->direction : Direction();
}

Metrics evaluate(const Run& run) { return evaluate(ScoreContext(run)); }

Metrics evaluate(const ScoreContext& context) {
  Metrics metrics;
  for (const MetricDefinition& defined : metric_definitions())
    metrics.emplace(defined.name, compute(defined, context));
  return metrics;
}

}  // namespace sim::score
