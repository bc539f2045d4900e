// Parts of the ground truth that recordings contain and the score reads; also the room's first surface along
// a ray.
#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <optional>
#include <vector>

namespace sim::score {

/// A surface of the room. Sizes are half-lengths as in MJCF, in m along the shape's axes S: plane: x and y, 0
/// if infinite; the surface is z = 0, seen only from z > 0 · box: x, y, z · sphere: radius · cylinder:
/// radius, half-height along z · ellipsoid: radii · capsule: radius, half of its straight part · triangle: of
/// a mesh, with corners at (0, 0), (size x, 0) and (size y, size z), seen from both sides.
struct Surface {
  enum class Kind { plane, box, sphere, cylinder, ellipsoid, capsule, triangle };
  Kind kind = Kind::box;
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
};

/// A footstep that steering was free to correct. Landings in W: x, y (m), yaw (rad).
struct StepCorrection {
  std::chrono::nanoseconds t{0};          ///< time of the decision
  double ahead = 0, aside = 0, turn = 0;  ///< correction in the expected landing's axes, m and rad
  bool left = false;                      ///< foot
  Eigen::Vector3d desired = Eigen::Vector3d::Zero();   ///< landing on the commanded path
  Eigen::Vector3d expected = Eigen::Vector3d::Zero();  ///< estimated landing without the correction
};

/// A foot at one instant, each vector (x m, y m, yaw rad).
struct TrueFoot {
  Eigen::Vector3d truth = Eigen::Vector3d::Zero(), plan = Eigen::Vector3d::Zero();  ///< pose of the sole
  bool planned_down = true;                                                         ///< stands in the plan
  double load_n = 0;  ///< vertical force, mean since the instant before
  /// Slip within the friction cone, caused by the contact model, since the previous instant.
  Eigen::Vector3d creep = Eigen::Vector3d::Zero();
};
/// True and planned poses of the feet.
struct TrueFeet {
  std::chrono::nanoseconds t{0};
  TrueFoot left, right;
  /// Whether a joint's torque was at its limit since the previous instant; absent if the robot has no
  /// limits.
  std::optional<bool> torque_limited = {};
};

/// The error-free reading of the IMU in the body: the specific force in its axes, mean since the previous
/// instant.
struct TrueForce {
  std::chrono::nanoseconds t{0};
  Eigen::Vector3d f = Eigen::Vector3d::Zero();  ///< m/s²
};

struct Hit {
  std::size_t surface = 0;  ///< index of the surface
  double distance = 0;      ///< m
};

/// Returns the first surface on the ray from `origin` along the unit vector `direction` (both in W), at a
/// distance > 0. From inside a solid, the ray hits the surface on its way out.
std::optional<Hit> first_surface(const std::vector<Surface>& surfaces, const Eigen::Vector3d& origin,
                                 const Eigen::Vector3d& direction);

/// Returns the distance of first_surface().
std::optional<double> first_hit(const std::vector<Surface>& surfaces, const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction);

}  // namespace sim::score
