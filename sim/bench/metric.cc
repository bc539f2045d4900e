#include "sim/bench/metric.h"

#include <algorithm>

namespace sim::bench {
namespace {

constexpr Metric kMetrics[]{
    {"ate_se3_rmse_m", "m", "absolute trajectory error of the camera after SE(3) alignment, rmse"},
    {"rmse_m", "m", "error of the camera's position without any alignment, rmse"},
    {"end_position_error_m", "m", "error of the camera's position at the end, not aligned"},
    {"end_yaw_error_deg", "deg", "error of the camera's yaw at the end, estimate minus truth"},
    {"height_range_m", "m", "highest minus lowest estimated camera position"},
    {"true_height_range_m", "m", "highest minus lowest true camera position"},
    {"plan_drift_x_m", "m", "true minus planned waist at the end, ahead in the start's frame"},
    {"plan_drift_y_m", "m", "true minus planned waist at the end, to the left in the start's frame"},
    {"plan_drift_yaw_deg", "deg", "true minus planned yaw of the waist at the end"},
    {"loop_landmarks", "", "early landmarks seen again at the right place after the turn"},
    {"loop_closed", "", "1 if at least 3 landmarks closed the loop, else 0"},
    {"nees_position_mean", "", "mean normalised estimation error squared of the position; 3 expected"},
    {"nees_orientation_mean", "", "mean normalised estimation error squared of the orientation; 3 expected"},
    {"path_length_m", "m", "length of the camera's true path"},
};

}  // namespace

std::span<const Metric> metrics() { return kMetrics; }

const Metric* find_metric(std::string_view name) {
  const auto all = metrics();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Metric& m) { return m.name == name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace sim::bench
