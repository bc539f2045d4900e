#include "sim/live/self_check.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numbers>

namespace sim::live {
namespace {

double yaw_deg(const InertialCheck& inertial) { return inertial.worst_yaw_rad() * 180 / std::numbers::pi; }

}  // namespace

std::string SelfCheck::complaint() const {
  const std::string path =
      fmt::format("self-check: the ideal gyro and accelerometer, integrated over {:.1f} s, leave the true ",
                  slam::seconds(inertial.longest()));
  if (!(inertial.worst_position_m() <= kInertialPosition_m))
    return fmt::format("{}path by {:.4f} m, more than {} m", path, inertial.worst_position_m(),
                       kInertialPosition_m);
  if (!(yaw_deg(inertial) <= kInertialYaw_deg))
    return fmt::format("{}heading by {:.4f} deg, more than {} deg", path, yaw_deg(inertial),
                       kInertialYaw_deg);
  const std::optional<double> distance = view ? view->median_px() : std::nullopt;
  if (distance && !(*distance <= kView_px))
    return fmt::format(
        "self-check: points of the room are {:.2f} px from their projection by the true pose, more than {} "
        "px",
        *distance, kView_px);
  return "";
}

std::string SelfCheck::json() const {
  nlohmann::ordered_json json{
      {"inertial_position_m", {{"worst", inertial.worst_position_m()}, {"at_most", kInertialPosition_m}}},
      {"inertial_yaw_deg", {{"worst", yaw_deg(inertial)}, {"at_most", kInertialYaw_deg}}}};
  if (view) {
    const std::optional<double> distance = view->median_px();
    json["view_px"] = {
        {"median", distance ? nlohmann::ordered_json(*distance) : nlohmann::ordered_json(nullptr)},
        {"points", view->points()},
        {"at_most", kView_px}};
  }
  json["complaint"] = complaint();
  return json.dump(2) + "\n";
}

}  // namespace sim::live
