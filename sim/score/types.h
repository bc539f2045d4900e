// Parts of the ground truth that recordings keep and the score reads; the first surface of the room on a ray.
#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <optional>
#include <vector>

namespace sim::score {

/// A surface of the room. Sizes are the half-lengths of MJCF, in m along the axes S of the shape: plane: x
/// and y, 0 if infinite; the surface is z = 0, seen from z > 0 only · box: x, y, z · sphere: radius ·
/// cylinder: radius, half-height along z · ellipsoid: radii · capsule: radius, half of its straight part ·
/// triangle: of a mesh, with corners at (0, 0), (size x, 0) and (size y, size z), seen from both sides.
struct Surface {
  enum class Kind { plane, box, sphere, cylinder, ellipsoid, capsule, triangle };
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

/// A foot at one instant, each vector (x m, y m, yaw rad).
struct TrueFoot {
  Eigen::Vector3d truth = Eigen::Vector3d::Zero(), plan = Eigen::Vector3d::Zero();  ///< of the sole
  bool planned_down = true;                                                         ///< the plan has it stand
  double load_n = 0;  ///< vertical force, mean since the instant before
  /// Slip below the friction cone that the contact model causes, since the instant before.
  Eigen::Vector3d creep = Eigen::Vector3d::Zero();
};
/// True and planned poses of the feet.
struct TrueFeet {
  std::chrono::nanoseconds t{0};
  TrueFoot left, right;
  /// A joint's torque has been at its limit since the instant before; absent: the robot has no
  /// limits.
  std::optional<bool> torque_limited = {};
};

/// The reading of the IMU in the body without errors: the specific force in its axes, mean since the instant
/// before.
struct TrueForce {
  std::chrono::nanoseconds t{0};
  Eigen::Vector3d f = Eigen::Vector3d::Zero();  ///< m/s²
};

struct Hit {
  std::size_t surface = 0;  ///< its index
  double distance = 0;      ///< m
};

/// Returns the first surface on the ray along the unit vector `direction` from `origin` (both in W), at a
/// distance > 0. From inside a solid the ray meets its surface on the way out.
std::optional<Hit> first_surface(const std::vector<Surface>& surfaces, const Eigen::Vector3d& origin,
                                 const Eigen::Vector3d& direction);

/// Returns the distance of first_surface().
std::optional<double> first_hit(const std::vector<Surface>& surfaces, const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction);

}  // namespace sim::score
