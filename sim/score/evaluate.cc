#include "sim/score/evaluate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sim/score/alignment.h"
#include "sim/score/errors.h"

namespace sim::score {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kFirstMotion_m = 0.001;  // the planned waist has moved by more than this from its start

// A metric's value, or why there is none.
struct Value {
  Value(double v) : value(v) {}
  static Value none(std::string reason) {
    Value v(0);
    v.value.reset();
    v.reason = std::move(reason);
    return v;
  }
  std::optional<double> value;
  std::string reason;
};

// A run with what several metrics need, worked out once.
struct Scored {
  explicit Scored(const Run& r) : run(r) {
    begin = first_motion();
    if (!begin) return;
    for (const StampedPose& pose : r.truth_camera)
      if (pose.t >= *begin) truth_camera.push_back(pose);
    if (r.estimate)
      for (const EstimatedPose& pose : *r.estimate)
        if (pose.t >= *begin) estimate.push_back({pose.t, pose.X_WC});
    pairs = pair_by_stamp(truth_camera, estimate);
  }

  std::optional<Stamp> first_motion() const {
    for (const StampedPose& pose : run.plan_waist)
      if ((pose.X.translation() - run.plan_waist.front().X.translation()).norm() > kFirstMotion_m)
        return pose.t;
    return std::nullopt;
  }

  // Why nothing can be said of the estimate; empty if something can.
  std::string no_estimate() const {
    if (!run.estimate) return "the filter was not run";
    if (run.diverged) return "the filter diverged: " + *run.diverged;
    if (!begin) return "the plan never moves";
    if (pairs.empty()) return "no estimate has the stamp of a true pose";
    return "";
  }

  const Run& run;
  std::optional<Stamp> begin;  // of scoring
  Trajectory truth_camera, estimate;
  std::vector<PosePair> pairs;
};

Value ate_se3_rmse(const Scored& s) {
  if (const std::string why = s.no_estimate(); !why.empty()) return Value::none(why);
  const auto S = align(s.pairs, Alignment::se3);
  if (const auto* none = std::get_if<NoAlignment>(&S)) return Value::none(none->reason);
  return root_mean_square(position_errors(transformed(std::get<Similarity>(S), s.pairs)));
}

Value rmse(const Scored& s) {
  if (const std::string why = s.no_estimate(); !why.empty()) return Value::none(why);
  return root_mean_square(position_errors(s.pairs));
}

Value end_position_error(const Scored& s) {
  if (const std::string why = s.no_estimate(); !why.empty()) return Value::none(why);
  return position_errors({s.pairs.back()}).front();
}

Value end_yaw_error(const Scored& s) {
  if (const std::string why = s.no_estimate(); !why.empty()) return Value::none(why);
  return std::abs(yaw_error(s.pairs.back())) / kDegree;
}

Value estimated_height_range(const Scored& s) {
  if (const std::string why = s.no_estimate(); !why.empty()) return Value::none(why);
  return height_range(s.estimate);
}

Value true_height_range(const Scored& s) {
  if (s.truth_camera.empty()) return Value::none("the plan never moves");
  return height_range(s.truth_camera);
}

Value true_path_length(const Scored& s) {
  if (s.truth_camera.empty()) return Value::none("the plan never moves");
  return path_length(s.truth_camera);
}

// What the plan alone would have scored as an estimate.
Value plan_rmse(const Scored& s) {
  const std::vector<PosePair> pairs = pair_by_stamp(s.truth_camera, s.run.plan_camera);
  if (pairs.empty())
    return Value::none("no planned camera pose from the first motion on has the stamp of a true one");
  return root_mean_square(position_errors(pairs));
}

template <typename Part>
Value plan_drift(const Scored& s, Part part) {
  const std::vector<PosePair> pairs = pair_by_stamp(s.run.truth_waist, s.run.plan_waist);
  if (pairs.empty()) return Value::none("no planned waist pose has the stamp of a true one");
  return part(drift(pairs.back().X_true, pairs.back().X_estimate, s.run.plan_waist.front().X));
}

Value plan_drift_x(const Scored& s) {
  return plan_drift(s, [](const Drift& d) { return d.x; });
}
Value plan_drift_y(const Scored& s) {
  return plan_drift(s, [](const Drift& d) { return d.y; });
}
Value plan_drift_yaw(const Scored& s) {
  return plan_drift(s, [](const Drift& d) { return d.yaw / kDegree; });
}

Value loop_landmark_count(const Scored& s) {
  if (const std::string why = s.no_estimate(); !why.empty()) return Value::none(why);
  const auto marks = turn_marks(s.run.plan_waist);
  if (!marks) return Value::none("what was walked of the plan turns by less than 350 degrees");
  return static_cast<double>(
      loop_landmarks(s.run.landmarks, *marks, s.run.truth_camera, s.run.surfaces, s.run.camera).size());
}

Value loop_closed(const Scored& s) {
  Value count = loop_landmark_count(s);
  if (count.value) count.value = *count.value >= 3 ? 1 : 0;
  return count;
}

template <typename Part>
Value mean_nees(const Scored& s, Part part) {
  if (const std::string why = s.no_estimate(); !why.empty()) return Value::none(why);
  std::vector<double> values;
  for (const EstimatedPose& pose : *s.run.estimate) {
    const std::vector<PosePair> pair = pair_by_stamp(s.truth_camera, {{pose.t, pose.X_WC}});
    if (pair.empty()) continue;
    const auto nees = pose_nees(pair[0].X_true, pair[0].X_estimate, pose.covariance);
    if (!nees) return Value::none("a covariance of the estimate is not positive definite");
    values.push_back(part(*nees));
  }
  return mean(values);
}

Value nees_position(const Scored& s) {
  return mean_nees(s, [](const PoseNees& nees) { return nees.position; });
}
Value nees_orientation(const Scored& s) {
  return mean_nees(s, [](const PoseNees& nees) { return nees.orientation; });
}

struct Row {
  MetricDefinition definition;
  Value (*value)(const Scored&);
};

constexpr std::array kRows{
    Row{{"ate_se3_rmse_m", "m",
         "absolute trajectory error: root mean square distance between estimated and true camera positions "
         "after the "
         "turn and shift (SE(3), no scale) that brings them nearest; frames from the first planned motion on",
         Worst::largest},
        ate_se3_rmse},
    Row{{"rmse_m", "m",
         "root mean square distance between estimated and true camera positions, without alignment: both in "
         "W, the "
         "plan's world at t = 0; frames from the first planned motion on (planned waist more than 1 mm from "
         "its start)",
         Worst::largest},
        rmse},
    Row{{"end_position_error_m", "m",
         "distance between estimated and true camera position at the last frame, without alignment",
         Worst::largest},
        end_position_error},
    Row{{"end_yaw_error_deg", "deg",
         "size of the turn about the vertical that brings the estimated camera orientation nearest to the "
         "true one at "
         "the last frame, without alignment",
         Worst::largest},
        end_yaw_error},
    Row{{"height_range_m", "m",
         "greatest minus least estimated camera height from the first planned motion on", Worst::largest},
        estimated_height_range},
    Row{{"true_height_range_m", "m",
         "greatest minus least true camera height from the first planned motion on", Worst::largest},
        true_height_range},
    Row{{"plan_rmse_m", "m", "what rmse_m would be if the planned camera pose were the estimate",
         Worst::largest},
        plan_rmse},
    Row{{"plan_drift_x_m", "m",
         "true minus planned waist position at the last frame, ahead in axes of the planned start",
         Worst::largest_magnitude},
        plan_drift_x},
    Row{{"plan_drift_y_m", "m",
         "true minus planned waist position at the last frame, to the left in axes of the planned start",
         Worst::largest_magnitude},
        plan_drift_y},
    Row{{"plan_drift_yaw_deg", "deg", "true minus planned waist yaw at the last frame, left positive",
         Worst::largest_magnitude},
        plan_drift_yaw},
    Row{{"loop_landmarks", "1",
         "landmarks begun before the plan has turned a quarter of its total turn, whose surface point by "
         "truth was out "
         "of the field of view for at least 5 s in one stretch, and of which after three quarters of the "
         "turn a match "
         "was accepted within 3 px of where truth puts that surface point; for plans that turn by at least "
         "350 degrees",
         Worst::smallest},
        loop_landmark_count},
    Row{{"loop_closed", "1", "1 if loop_landmarks is at least 3, else 0", Worst::smallest}, loop_closed},
    Row{{"nees_position_mean", "1",
         "mean of the camera position error squared, normalised by its covariance, from the first planned "
         "motion on; 3 "
         "is expected",
         Worst::largest},
        nees_position},
    Row{{"nees_orientation_mean", "1",
         "mean of the camera orientation error squared, normalised by its covariance, from the first planned "
         "motion "
         "on; 3 is expected",
         Worst::largest},
        nees_orientation},
    Row{{"path_length_m", "m",
         "length of the true camera's path, from frame to frame, from the first planned motion on",
         Worst::smallest},
        true_path_length},
};

constexpr auto kDefinitions = [] {
  std::array<MetricDefinition, kRows.size()> definitions{};
  for (std::size_t i = 0; i < kRows.size(); ++i) definitions[i] = kRows[i].definition;
  return definitions;
}();

Metric metric(const Row& row, const Scored& scored) {
  Value value = row.value(scored);
  if (value.value && !std::isfinite(*value.value)) value = Value::none("the value is not finite");
  return {value.value, std::string(row.definition.unit), value.reason};
}

}  // namespace

std::span<const MetricDefinition> metric_definitions() { return kDefinitions; }

const MetricDefinition* find_metric(std::string_view name) {
  const auto found =
      std::find_if(kDefinitions.begin(), kDefinitions.end(), [&](const auto& m) { return m.name == name; });
  return found == kDefinitions.end() ? nullptr : &*found;
}

Metrics evaluate(const Run& run) {
  const Scored scored(run);
  Metrics metrics;
  for (const Row& row : kRows) metrics.emplace(row.definition.name, metric(row, scored));
  return metrics;
}

}  // namespace sim::score
