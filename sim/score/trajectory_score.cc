#include "sim/score/trajectory_score.h"

#include <cmath>
#include <numbers>

namespace sim::score {
namespace {

double of_difference(const Eigen::Isometry3d& E, Relation relation) {
  const auto angle = [&] { return rotation_vector(E.linear()).norm(); };
  switch (relation) {
    case Relation::trans_part:
    case Relation::point_distance:
      return E.translation().norm();
    case Relation::angle_deg:
      return angle() * 180 / std::numbers::pi;
    case Relation::angle_rad:
      return angle();
    case Relation::rot_part:
      return (E.linear() - Eigen::Matrix3d::Identity()).norm();
    case Relation::full:
      return (E.matrix() - Eigen::Matrix4d::Identity()).norm();
  }
  return 0;
}

double distance(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
  return (to.translation() - from.translation()).norm();
}

}  // namespace

std::string unit(Relation relation) {
  switch (relation) {
    case Relation::trans_part:
    case Relation::point_distance:
      return "m";
    case Relation::angle_deg:
      return "deg";
    case Relation::angle_rad:
      return "rad";
    default:
      return "1";
  }
}

std::vector<double> pose_errors(const std::vector<PosePair>& pairs, Relation relation) {
  std::vector<double> errors;
  for (const PosePair& pair : pairs)
    errors.push_back(of_difference(pair.X_true.inverse() * pair.X_estimate, relation));
  return errors;
}

std::vector<double> motion_errors(const std::vector<PosePair>& pairs, const std::vector<Span>& over,
                                  Relation relation) {
  std::vector<double> errors;
  for (const Span& span : over) {
    const PosePair &a = pairs[span.from], &b = pairs[span.to];
    errors.push_back(relation == Relation::point_distance
                         ? std::abs(distance(a.X_true, b.X_true) - distance(a.X_estimate, b.X_estimate))
                         : of_difference(relative_difference(pairs, span), relation));
  }
  return errors;
}

OrAbsent<Similarity> align_first(const std::vector<PosePair>& pairs, Alignment alignment, std::size_t count) {
  if (count == 0 || count >= pairs.size()) return align(pairs, alignment);
  return align({pairs.begin(), pairs.begin() + static_cast<std::ptrdiff_t>(count)}, alignment);
}

}  // namespace sim::score
