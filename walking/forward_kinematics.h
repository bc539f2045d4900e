// Where a sole is for given leg angles: HRP-2's leg, joint by joint.
#pragma once

#include <Eigen/Geometry>

#include "walking/plan.h"

namespace walking {

/// X_BS: the sole (point below the ankle) in the waist; q of the leg: hip yaw, roll, pitch, knee, ankle
/// pitch, roll (rad).
Eigen::Isometry3d sole_in_waist(Side side, const Eigen::Matrix<double, 6, 1>& q);

}  // namespace walking
