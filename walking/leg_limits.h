// The ranges of HRP-2's leg joints, within which a plan must stay.
#pragma once

#include <optional>
#include <string>

#include "walking/inverse_kinematics.h"

namespace walking {

/// Lowest and highest angle of each joint of a leg, rad, in the order of LegSolution::q.
struct LegLimits {
  Eigen::Matrix<double, 6, 1> lowest, highest;
};

/// Of the stack-of-tasks model of HRP-2; the left leg mirrors the right one.
LegLimits leg_limits(Side side);

/// Why the legs cannot take this posture, in words ("the left foot is out of the leg's reach"); nothing if
/// they can.
std::optional<std::string> leg_obstacle(const BodySolution& body);

}  // namespace walking
