// The state before the first observation.
#pragma once

#include <Eigen/Geometry>

#include "slam/options.h"
#include "slam/state.h"

namespace slam {

/// The mean of a robot at rest whose camera is at X_WC; all other parameters are 0.
RobotVector initial_mean(const Eigen::Isometry3d& X_WC);

/// Mean and covariance of a robot at rest whose camera is near X_WC. The covariance is diagonal but for the
/// orientation, whose quaternion varies by small rotations only.
RobotState initial_state(const Eigen::Isometry3d& X_WC, const Options& options);

}  // namespace slam
