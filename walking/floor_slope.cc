#include "walking/floor_slope.h"

#include <algorithm>

namespace walking {
namespace {

constexpr double kLag_s = 1;  // slower than a sole that rocks on its edge
// A loaded sole tilts by about this much as the center of pressure moves, to either side in each stride. An
// ankle that followed it at once would yield.
constexpr double kSway = 0.02, kSwayLag_s = 3;
constexpr double kLoaded = 0.3;     // fraction of the weight; a sole with more load lies flat on the floor
constexpr double kSteepest = 0.25;  // limit in case of faulty sensors

}  // namespace

void FloorSlope::update(const Reference& reference, const Eigen::Vector2d& tilt,
                        const SensorReadings& readings) {
  const Eigen::Matrix3d R_PB =
      reference.X_PB.linear() * (Eigen::AngleAxisd(tilt.y(), Eigen::Vector3d::UnitY()) *
                                 Eigen::AngleAxisd(tilt.x(), Eigen::Vector3d::UnitX()))
                                    .toRotationMatrix();
  for (const auto& [side, wrench] : {std::pair(Side::left, &readings.left), {Side::right, &readings.right}}) {
    const double load = wrench->force.z() / (robot_.mass * kGravity);
    if (load < kLoaded) continue;
    const Eigen::Vector3d up =
        R_PB * sole_in_base(robot_, side, leg_angles(robot_.leg(side), readings.q)).linear().col(2);
    const Eigen::Vector2d measured = -up.head<2>() / up.z();
    const Eigen::Vector2d change = measured - gradient_, sway = change.cwiseMax(-kSway).cwiseMin(kSway);
    gradient_ += std::min(load, 1.0) * kPeriod * ((change - sway) / kLag_s + sway / kSwayLag_s);
  }
  gradient_ = gradient_.cwiseMax(-kSteepest).cwiseMin(kSteepest);
}

Posture FloorSlope::adapted(Posture posture) const {
  const Eigen::Vector3d normal(-gradient_.x(), -gradient_.y(), 1);
  const Eigen::Matrix3d turn =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal).toRotationMatrix();
  for (Eigen::Isometry3d* const X_PS : {&posture.X_PL, &posture.X_PR}) {
    const Eigen::Vector2d from_waist = (X_PS->translation() - posture.X_PB.translation()).head<2>();
    X_PS->translation().z() += gradient_.dot(from_waist);
    X_PS->linear() = turn * X_PS->linear();
  }
  return posture;
}

}  // namespace walking
