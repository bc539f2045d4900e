// How far HRP-2's leg joints turn: what a plan must stay within.
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

/// What keeps the legs from taking this posture, in words ("the left leg is too short"); nothing if they can.
std::optional<std::string> legs_prevent(const BodySolution& body);

}  // namespace walking
