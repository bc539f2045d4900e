// Poses over time, the pairing of two trajectories by their stamps, and the errors of their pairs.
#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <numbers>
#include <optional>
#include <vector>

#include "sim/files/trajectory_file.h"

namespace sim::score {

using Stamp = std::chrono::nanoseconds;

using files::TimedPose;

/// In order of time, no stamp twice.
using Trajectory = std::vector<TimedPose>;

/// The true (or reference) and the estimated pose at one time, both in the same world.
struct PosePair {
  Stamp t{0};
  Eigen::Isometry3d X_true = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d X_estimate = Eigen::Isometry3d::Identity();
};

/// Pairs each pose of the shorter trajectory with the pose of the other that is nearest in time (the earlier
/// of two), if they are at most `most` apart; `offset` is added to the estimate's stamps. As in evo, except
/// that each pose is used at most once: with the nearest of several.
std::vector<PosePair> pair_by_nearest(const Trajectory& truth, const Trajectory& estimate, Stamp most,
                                      Stamp offset = Stamp(0));

/// The same for poses of one moment: at most 0.1 ms apart, since some programs round stamps.
std::vector<PosePair> pair_by_stamp(const Trajectory& truth, const Trajectory& estimate);

/// Pairs each estimate with the truth interpolated at its stamp; skips estimates outside the truth's time and
/// between two true poses that are more than most_gap apart.
std::vector<PosePair> pair_by_interpolation(const Trajectory& truth, const Trajectory& estimate,
                                            Stamp most_gap);

/// Interpolates position linearly, orientation along the shortest turn. Returns nothing outside the
/// trajectory's time.
std::optional<Eigen::Isometry3d> interpolate(const Trajectory& trajectory, Stamp t);

/// Sum of the distances between successive positions, m.
double path_length(const Trajectory& trajectory);

inline constexpr double kDegree = std::numbers::pi / 180;  ///< rad

/// Rotation vector (rad) of a rotation matrix, its length in [0, π].
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R);

/// The angle (rad, in (−π, π]) of the rotation about z that is nearest to R in the Frobenius norm.
double yaw(const Eigen::Matrix3d& R);

/// |p_true − p_estimate| of each pair, m.
std::vector<double> position_errors(const std::vector<PosePair>& pairs);
/// The angle of R_estimateᵀ R_true of each pair, rad.
std::vector<double> orientation_errors(const std::vector<PosePair>& pairs);
/// The rotation about W's z that turns the estimated orientation closest to the true one, rad, left positive.
double yaw_error(const PosePair& pair);

/// Greatest minus least height (z), m; 0 for none.
double height_range(const Trajectory& trajectory);

/// The drift of the robot from its plan in axes of the plan's first pose: x forward, y left (m), yaw (rad).
struct Drift {
  double x = 0, y = 0, yaw = 0;
};
/// True minus planned. X_PB_start gives the axes.
Drift drift(const Eigen::Isometry3d& X_WB_true, const Eigen::Isometry3d& X_PB,
            const Eigen::Isometry3d& X_PB_start);

}  // namespace sim::score
