// Alignment of an estimated trajectory with the true one.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "sim/score/statistics.h"
#include "sim/score/trajectory.h"

namespace sim::score {

/// none: no alignment · origin: first pose onto first pose · yaw_position: rotation about z and translation
/// by least squares of positions · se3: rotation and translation by least squares of positions · sim3:
/// rotation, translation and scale by least squares of positions (Umeyama 1991) · scale: only the scale of
/// sim3.
enum class Alignment { none, origin, yaw_position, se3, sim3, scale };

/// Returns "none", "origin", "yaw", "se3", "sim3" or "scale".
std::string name_of(Alignment alignment);
/// Returns the alignment of that name; nothing for another word.
std::optional<Alignment> alignment_of(const std::string& name);

/// p -> scale R p + translation; orientations are turned by R.
struct Similarity {
  double scale = 1;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Isometry3d operator*(const Eigen::Isometry3d& X) const;
};

/// Returns the transformation of the pairs' estimates onto their truth. Absent if the positions do not
/// determine it: no pairs; all positions in one point (yaw_position: above one another) or, for se3 and sim3,
/// on one line.
OrAbsent<Similarity> align(const std::vector<PosePair>& pairs, Alignment alignment);

/// Returns the pairs with their estimates transformed.
std::vector<PosePair> transformed(const Similarity& S, std::vector<PosePair> pairs);

}  // namespace sim::score
