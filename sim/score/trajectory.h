// Poses over time, and the pairing of two such trajectories by their stamps.
#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <numbers>
#include <optional>
#include <vector>

namespace sim::score {

using Stamp = std::chrono::nanoseconds;

/// A pose at a time; the variable that holds it names the frames.
struct StampedPose {
  Stamp t{0};
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
};

/// In order of time, no stamp twice.
using Trajectory = std::vector<StampedPose>;

/// The true (or reference) and the estimated pose at one time, both in the same world.
struct PosePair {
  Stamp t{0};
  Eigen::Isometry3d X_true = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d X_estimate = Eigen::Isometry3d::Identity();
};

/// The pairs of exactly equal stamps, in order of time.
std::vector<PosePair> pair_by_stamp(const Trajectory& truth, const Trajectory& estimate);

/// Pairs each pose of the shorter trajectory with the one of the other nearest in time (of two as near the
/// earlier), if it is off by at most `most`; `offset` is added to the estimate's stamps. As in the evaluation
/// program evo, except that each pose is used once at most: with the nearest of several.
std::vector<PosePair> pair_by_nearest(const Trajectory& truth, const Trajectory& estimate, Stamp most,
                                      Stamp offset = Stamp(0));

/// Pairs each estimate with the truth interpolated at its stamp; estimates outside the truth's time are left
/// out.
std::vector<PosePair> pair_by_interpolation(const Trajectory& truth, const Trajectory& estimate);

/// Position linearly, orientation along the shortest turn; nothing outside the trajectory's time.
std::optional<Eigen::Isometry3d> interpolate(const Trajectory& trajectory, Stamp t);

/// Sum of the distances between successive positions, m.
double path_length(const Trajectory& trajectory);

inline constexpr double kDegree = std::numbers::pi / 180;  ///< rad

/// Rotation vector (rad) of a rotation matrix, its length in [0, π].
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R);

/// The angle (rad, in (−π, π]) of the rotation about z that is nearest to R in the Frobenius norm.
double yaw(const Eigen::Matrix3d& R);

}  // namespace sim::score
