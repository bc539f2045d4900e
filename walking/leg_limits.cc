#include "walking/leg_limits.h"

#include <array>
#include <numbers>

namespace walking {
namespace {

constexpr std::array kJointNames{"hip yaw", "hip roll", "hip pitch", "knee", "ankle pitch", "ankle roll"};

std::optional<std::string> obstacle_of(Side side, const Eigen::Matrix<double, 6, 1>& q, bool reached) {
  const std::string leg = side == Side::left ? "left" : "right";
  if (!reached) return "the " + leg + " foot is out of the leg's reach";
  const LegLimits limits = leg_limits(side);
  for (int i = 0; i < 6; ++i) {
    if (q(i) >= limits.lowest(i) && q(i) <= limits.highest(i)) continue;
    return "the " + leg + " " + kJointNames[i] + " would have to turn to " +
           std::to_string(q(i) * 180 / std::numbers::pi) + " degrees";
  }
  return std::nullopt;
}

}  // namespace

LegLimits leg_limits(Side side) {
  LegLimits right;
  right.lowest << -45, -35, -125, -2, -75, -20;
  right.highest << 30, 20, 42, 150, 42, 35;
  right.lowest *= std::numbers::pi / 180;
  right.highest *= std::numbers::pi / 180;
  if (side == Side::right) return right;
  LegLimits left = right;
  for (const int mirrored : {0, 1, 5}) {
    left.lowest(mirrored) = -right.highest(mirrored);
    left.highest(mirrored) = -right.lowest(mirrored);
  }
  return left;
}

std::optional<std::string> leg_obstacle(const BodySolution& body) {
  auto obstacle = obstacle_of(Side::right, body.q.segment<6>(0), body.right_reached);
  if (!obstacle) obstacle = obstacle_of(Side::left, body.q.segment<6>(6), body.left_reached);
  return obstacle;
}

}  // namespace walking
