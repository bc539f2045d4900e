#include "sim/score/evaluate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/score/metric_values.h"
#include "sim/score/scored.h"

namespace sim::score {
namespace {

struct Row {
  MetricDefinition definition;
  Value (*value)(const Scored&);
};

constexpr std::array kRows{
    Row{{"ate_se3_rmse_m", "m",
         "absolute trajectory error: root mean square distance between estimated and true camera positions "
         "after the turn and shift (SE(3), no scale) that brings them nearest; frames from the first planned "
         "motion on",
         Worst::largest},
        ate_se3_rmse},
    Row{{"rmse_m", "m",
         "root mean square distance between estimated and true camera positions, without alignment: both in "
         "W, the plan's world at t = 0; frames from the first planned motion on (planned waist more than 1 "
         "mm from its start)",
         Worst::largest},
        rmse},
    Row{{"ate_yaw_rmse_m", "m", "as ate_se3_rmse_m, with a turn about the vertical alone and a shift",
         Worst::largest},
        ate_yaw_rmse},
    Row{{"ate_sim3_rmse_m", "m", "as ate_se3_rmse_m, with a scale besides", Worst::largest}, ate_sim3_rmse},
    Row{{"scale_error_percent", "%",
         "by how much the estimated path is too large, by the scale of the alignment of ate_sim3_rmse_m",
         Worst::largest_magnitude},
        scale_error},
    Row{{"rpe_1m_m", "m",
         "relative pose error: root mean square translation error of the motion over 1 m of the true path "
         "(from each frame to the one nearest to 1 m further, within 10 %)",
         Worst::largest},
        relative_1m_translation},
    Row{{"rpe_1m_deg", "deg", "root mean square rotation error over the same spans of 1 m", Worst::largest},
        relative_1m_rotation},
    Row{{"end_position_error_m", "m",
         "distance between estimated and true camera position at the last frame, without alignment",
         Worst::largest},
        end_position_error},
    Row{{"drift_percent", "%", "end_position_error_m in percent of path_length_m", Worst::largest},
        drift_percent},
    Row{{"end_yaw_error_deg", "deg",
         "size of the turn about the vertical that brings the estimated camera orientation nearest to the "
         "true one at the last frame, without alignment",
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
    Row{{"slip_landing_m", "m",
         "way of the soles on the ground, end minus begin, summed over all landings: from the first touch "
         "until a foot first carries 40 % of the weight",
         Worst::largest},
        foot_slip_landing},
    Row{{"slip_support_m", "m", "likewise while a foot carries the robot", Worst::largest},
        foot_slip_support},
    Row{{"slip_lift_off_m", "m",
         "likewise from when a foot last carries 40 % of the weight until it leaves the ground",
         Worst::largest},
        foot_slip_lift_off},
    Row{{"slip_landing_deg", "deg",
         "turns of the soles on the ground, end minus begin, sizes summed over all landings", Worst::largest},
        foot_turn_landing},
    Row{{"slip_support_deg", "deg", "likewise while a foot carries the robot", Worst::largest},
        foot_turn_support},
    Row{{"slip_lift_off_deg", "deg", "likewise of feet about to leave the ground", Worst::largest},
        foot_turn_lift_off},
    Row{{"contact_creep_m", "m",
         "how much of slip_..._m the contact model could not hold although below the friction cone: a "
         "numerical artefact",
         Worst::largest},
        foot_creep},
    Row{{"contact_creep_deg", "deg", "likewise of slip_..._deg", Worst::largest}, foot_creep_turn},
    Row{{"slip_drift_x_m", "m", "share of plan_drift_x_m that comes from feet moving on the ground",
         Worst::largest_magnitude},
        slip_drift_x},
    Row{{"slip_drift_y_m", "m", "share of plan_drift_y_m likewise", Worst::largest_magnitude}, slip_drift_y},
    Row{{"slip_drift_yaw_deg", "deg", "share of plan_drift_yaw_deg likewise", Worst::largest_magnitude},
        slip_drift_yaw},
    Row{{"put_down_drift_x_m", "m",
         "share of plan_drift_x_m that comes from feet put down elsewhere than planned, seen from the other "
         "foot",
         Worst::largest_magnitude},
        put_down_drift_x},
    Row{{"put_down_drift_y_m", "m", "share of plan_drift_y_m likewise", Worst::largest_magnitude},
        put_down_drift_y},
    Row{{"put_down_drift_yaw_deg", "deg", "share of plan_drift_yaw_deg likewise", Worst::largest_magnitude},
        put_down_drift_yaw},
    Row{{"loop_landmarks", "1",
         "landmarks begun before the plan has turned a quarter of its total turn, whose surface point by "
         "truth was out of the field of view for at least 5 s in one stretch, and of which after three "
         "quarters of the turn a match was accepted within 3 px of where truth puts that surface point; for "
         "plans that turn by at least 350 degrees",
         Worst::smallest},
        loop_landmark_count},
    Row{{"loop_closed", "1", "1 if loop_landmarks is at least 3, else 0", Worst::smallest}, loop_closed},
    Row{{"loop_time_s", "s", "when the first of the loop_landmarks was found again", Worst::largest},
        loop_time},
    Row{{"loop_error_before_m", "m",
         "camera position error, without alignment, in the frame before loop_time_s", Worst::largest},
        loop_error_before},
    Row{{"loop_error_after_m", "m",
         "camera position error, without alignment, 1 s after loop_time_s, or at the last frame if that is "
         "earlier",
         Worst::largest},
        loop_error_after},
    Row{{"nees_position_mean", "1",
         "mean of the camera position error squared, normalised by its covariance, from the first planned "
         "motion on; 3 is expected",
         Worst::largest},
        nees_position},
    Row{{"nees_orientation_mean", "1",
         "mean of the camera orientation error squared, normalised by its covariance, from the first planned "
         "motion on; 3 is expected",
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

/// What compares lengths of the estimate with true ones, unless it fits the scale itself.
constexpr std::array<std::string_view, 11> kScaled{"ate_se3_rmse_m",
                                                   "rmse_m",
                                                   "ate_yaw_rmse_m",
                                                   "scale_error_percent",
                                                   "rpe_1m_m",
                                                   "drift_percent",
                                                   "height_range_m",
                                                   "end_position_error_m",
                                                   "loop_error_before_m",
                                                   "loop_error_after_m",
                                                   "nees_position_mean"};

Metric metric(const Row& row, const Scored& scored) {
  const bool scaled = std::find(kScaled.begin(), kScaled.end(), row.definition.name) != kScaled.end();
  const std::string& no_scale = scored.run.no_scale;
  Value value = scaled && !no_scale.empty() ? Value::none(no_scale) : row.value(scored);
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
