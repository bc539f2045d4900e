// Poses over time: pairing of two trajectories by stamps, errors of the pairs, alignment with the truth,
// relative pose errors, and errors normalized by their covariance.
#pragma once

#include <numbers>

#include "sim/files/trajectory_file.h"
#include "sim/score/statistics.h"

namespace sim::score {

using Stamp = std::chrono::nanoseconds;

using files::TimedPose, files::Matrix6d;

/// In chronological order, without repeated stamps.
using Trajectory = std::vector<TimedPose>;

/// The true (or reference) and the estimated pose at one time, both in the same world.
struct PosePair {
  Stamp t{0};
  Eigen::Isometry3d X_true = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d X_estimate = Eigen::Isometry3d::Identity();
};

/// Returns each pose of the shorter trajectory with the other trajectory's pose closest in time (the earlier
/// of two) if they are at most `most` apart. `offset` is added to the estimate's stamps. As in evo, except
/// that each pose is used at most once: with the closest of several.
std::vector<PosePair> pair_by_nearest(const Trajectory& truth, const Trajectory& estimate, Stamp most,
                                      Stamp offset = Stamp(0));

/// Returns pairs of poses at the same moment: at most 0.1 ms apart, because some programs round stamps.
inline std::vector<PosePair> pair_by_stamp(const Trajectory& truth, const Trajectory& estimate) {
  return pair_by_nearest(truth, estimate, std::chrono::microseconds(100));
}

/// Returns each estimate with the truth interpolated at its stamp. Skips estimates outside the truth's time
/// or between two true poses that are more than most_gap apart.
std::vector<PosePair> pair_by_interpolation(const Trajectory& truth, const Trajectory& estimate,
                                            Stamp most_gap);

/// Interpolates position linearly and orientation along the shortest turn. Returns nothing outside the
/// trajectory's time.
std::optional<Eigen::Isometry3d> interpolate(const Trajectory& trajectory, Stamp t);

/// Returns the sum of the distances between successive positions, m.
double path_length(const Trajectory& trajectory);

inline constexpr double kDegree = std::numbers::pi / 180;  ///< rad

/// Returns the rotation vector (rad) of a rotation matrix, its length in [0, π].
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R);

/// Returns the angle (rad, in (−π, π]) of the rotation about z that is nearest to R in the Frobenius norm.
double yaw(const Eigen::Matrix3d& R);

/// Returns |p_true − p_estimate| of each pair, m.
std::vector<double> position_errors(const std::vector<PosePair>& pairs);
/// Returns the angle of R_estimateᵀ R_true of each pair, rad.
std::vector<double> orientation_errors(const std::vector<PosePair>& pairs);
/// Returns the turn about W's z that best maps the estimated to the true orientation, rad, left positive.
double yaw_error(const PosePair& pair);

/// Returns the largest minus the smallest height (z), m; 0 for an empty trajectory.
double height_range(const Trajectory& trajectory);

/// Returns the robot's drift from its plan, true minus planned, in the axes of the plan's first pose: x
/// forward, y left (m), yaw (rad).
Eigen::Vector3d drift(const Eigen::Isometry3d& X_WB_true, const Eigen::Isometry3d& X_PB,
                      const Eigen::Isometry3d& X_PB_start);

/// none: no alignment · origin: first pose onto first pose · by least squares of positions: yaw_position:
/// rotation about z and translation · se3: rotation and translation · sim3: rotation, translation and scale
/// (Umeyama 1991) · scale: only the scale of sim3.
enum class Alignment { none, origin, yaw_position, se3, sim3, scale };  // origin is the last without a fit

/// Returns "none", "origin", "yaw", "se3", "sim3" or "scale".
std::string name_of(Alignment alignment);
/// Returns the alignment with that name, or nothing for other words.
std::optional<Alignment> alignment_of(const std::string& name);

/// p -> scale R p + translation; orientations are turned by R.
struct Similarity {
  double scale = 1;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Isometry3d operator*(const Eigen::Isometry3d& X) const;
};

/// Returns the transformation from the pairs' estimates to their truth. It is absent if the positions do not
/// determine it: there are none, they coincide (for yaw_position, horizontally) or, for se3 and sim3, they
/// are on a line.
OrAbsent<Similarity> align(const std::vector<PosePair>& pairs, Alignment alignment);

/// Returns why the scale of a sim3 alignment of these pairs is not credible: the scaled estimate does not
/// follow the truth, or the scale is far from 1. Returns nothing if it is credible.
std::optional<std::string> doubt_of_scale(const Similarity& S, const std::vector<PosePair>& pairs);

/// Returns the pairs with their estimates transformed.
std::vector<PosePair> transformed(const Similarity& S, std::vector<PosePair> pairs);

/// A kind of spans of motion. Consecutive spans, as in evo, go from the end of the previous span to the first
/// pose at least `delta` away (in meters only after delta was walked). Otherwise one span goes from each pose
/// to the later pose closest to delta away, within `tolerance` times delta (frames: exactly). For rotation,
/// all pairs of poses delta apart are used.
struct Spans {
  enum class Unit { frames, meters, seconds, radians, degrees } unit = Unit::frames;
  double delta = 1;
  bool all = false;
  double tolerance = 0.1;
  bool along_truth = false;  ///< meters and rotation: along the true path, not the estimated one
};

/// The first and last index of a span.
struct Span {
  std::size_t from = 0, to = 0;
};

/// Returns the spans, empty if the trajectory is too short. delta > 0 (frames: a whole number).
std::vector<Span> spans(const std::vector<PosePair>& pairs, const Spans& which);

/// Returns (X_true_from⁻¹ X_true_to)⁻¹ (X_estimate_from⁻¹ X_estimate_to), the difference over a span.
Eigen::Isometry3d relative_difference(const std::vector<PosePair>& pairs, const Span& span);

/// Normalized estimation error squared, 3 degrees of freedom each: 3 is expected (Bar-Shalom et al. 2001,
/// sec. 5.4).
struct PoseNees {
  double orientation = 0, position = 0;
};

/// Returns the NEES without alignment, or nothing if a block of the covariance is not positive definite.
/// covariance: of the error (Log(R_WC_estimateᵀ R_WC_true) in axes C, p_true − p_estimate in axes W).
std::optional<PoseNees> pose_nees(const Eigen::Isometry3d& X_WC_true, const Eigen::Isometry3d& X_WC_estimate,
                                  const Matrix6d& covariance);

}  // namespace sim::score
