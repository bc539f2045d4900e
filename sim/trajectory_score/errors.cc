#include "sim/trajectory_score/errors.h"

#include <cmath>
#include <numbers>

#include "sim/score/statistics.h"

namespace sim::trajectory_score {
namespace {

using score::PosePair, score::Span;

double of_difference(const Eigen::Isometry3d& E, Relation relation) {
  const auto angle = [&] { return score::rotation_vector(E.linear()).norm(); };
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
                         : of_difference(score::relative_difference(pairs, span), relation));
  }
  return errors;
}

ErrorStatistics describe(const std::vector<double>& errors) {
  const double m = score::mean(errors), rmse = score::root_mean_square(errors);
  std::vector<double> deviations;
  for (const double error : errors) deviations.push_back(error - m);
  return {errors.size(),
          rmse,
          m,
          score::median(errors),
          score::root_mean_square(deviations),
          score::quantile(errors, 0),
          score::quantile(errors, 1),
          score::quantile(errors, 0.95),
          score::quantile(errors, 0.99),
          rmse * rmse * static_cast<double>(errors.size())};
}

}  // namespace sim::trajectory_score
