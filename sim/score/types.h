// Parts of the ground truth that recordings keep and the score reads.
#pragma once

#include <Eigen/Geometry>
#include <chrono>

namespace sim::score {

/// A surface of the room. Sizes are the half-lengths of MJCF, in m along the axes S of the shape:
/// plane: x and y, 0 if infinite; the surface is z = 0, seen from z > 0 only · box: x, y, z · sphere: radius
/// · cylinder: radius, half-height along z · ellipsoid: three radii · capsule: radius, half-length of its
/// straight part.
struct Surface {
  enum class Kind { plane, box, sphere, cylinder, ellipsoid, capsule };
  Kind kind = Kind::box;
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
};

/// A footstep that steering was free to correct. Landings in W: x, y (m), yaw (rad).
struct StepCorrection {
  std::chrono::nanoseconds t{0};          ///< of the decision
  double ahead = 0, aside = 0, turn = 0;  ///< correction in axes of the expected landing, m and rad
  bool left = false;                      ///< foot
  Eigen::Vector3d desired = Eigen::Vector3d::Zero();   ///< landing on the commanded path
  Eigen::Vector3d expected = Eigen::Vector3d::Zero();  ///< landing without the correction, as estimated
};

}  // namespace sim::score
