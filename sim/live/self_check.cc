#include "sim/live/self_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>

#include "sim/files/json.h"
#include "sim/score/trajectory.h"
#include "walking/plan.h"

namespace sim::live {
namespace {

using namespace std::chrono_literals;

constexpr slam::Stamp kBegin = 10s, kLast = 30s;
constexpr double kBlow_m_s2 = 50;  // walking reaches 17
const Eigen::Vector3d kGravity_W(0, 0, -walking::kGravity);

void integrate(recording::TrueMotion& at, const Eigen::Vector3d& gyro, const Eigen::Vector3d& force,
               double dt) {
  const Eigen::Vector3d turned = gyro * dt;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(turned.norm(), turned.normalized()).toRotationMatrix();
  const Eigen::Matrix3d R = at.X_WG.linear(), R_end = R * turn;
  const Eigen::Vector3d a_W = (R * force + R_end * force) / 2 + kGravity_W, v = at.v_WG;
  at.v_WG += dt * a_W;
  at.X_WG.translation() += dt / 2 * (v + at.v_WG);
  at.X_WG.linear() = R_end;
}

double distance(const recording::TrueMotion& a, const recording::TrueMotion& b) {
  return (a.X_WG.translation() - b.X_WG.translation()).norm();
}
double yaw_between_deg(const recording::TrueMotion& a, const recording::TrueMotion& b) {
  return std::abs(score::yaw(a.X_WG.linear() * b.X_WG.linear().transpose())) * 180 / std::numbers::pi;
}

}  // namespace

void InertialCheck::add(const slam::InertialSample& gyro, const slam::InertialSample& accelerometer,
                        const recording::TrueMotion& end) {
  if (accelerometer.value.norm() > kBlow_m_s2) {
    half.reset();
    return integrations.assign(1, {end, end});
  }
  const double dt = slam::seconds(gyro.end - gyro.begin);
  for (Integration& i : integrations) integrate(i.fine, gyro.value, accelerometer.value, dt);
  if (!half) {
    half.emplace(gyro.value, accelerometer.value);
    return;
  }
  const auto raise = [](Error& error, double now, double by_step) {
    error = {std::max(error.worst, now), std::max(error.by_step, by_step)};
  };
  for (Integration& i : integrations) {
    integrate(i.coarse, (half->first + gyro.value) / 2, (half->second + accelerometer.value) / 2, 2 * dt);
    longest = std::max(longest, end.t - i.fine.t);
    raise(position_m, distance(i.fine, end), distance(i.fine, i.coarse));
    raise(yaw_deg, yaw_between_deg(i.fine, end), yaw_between_deg(i.fine, i.coarse));
  }
  half.reset();
  if (end.t - integrations.back().fine.t >= kBegin) integrations.push_back({end, end});
  if (end.t - integrations.front().fine.t >= kLast) integrations.pop_front();
}

std::optional<std::string> InertialCheck::complaint() const {
  for (const auto& [what, error, own, unit] : {std::tuple("path", position_m, kInertialPosition_m, "m"),
                                               {"heading", yaw_deg, kInertialYaw_deg, "deg"}})
    if (!(error.worst <= own + error.by_step))
      return fmt::format(
          "self-check: the ideal gyro and accelerometer, integrated over {:.1f} s, deviate from the true {} "
          "by {:.4f} {}, more than {:.4g} {}",
          slam::seconds(longest), what, error.worst, unit, own + error.by_step, unit);
  return std::nullopt;
}

std::string InertialCheck::json() const {
  using Json = nlohmann::ordered_json;
  const auto figures = [](const InertialCheck::Error& error, double own) {
    return Json{{"worst", error.worst}, {"at_most", own + error.by_step}};
  };
  Json json{{"inertial_position_m", figures(position_m, kInertialPosition_m)},
            {"inertial_yaw_deg", figures(yaw_deg, kInertialYaw_deg)}};
  json["complaint"] = complaint().value_or("");
  return files::json_text(json, 2) + "\n";
}

}  // namespace sim::live
