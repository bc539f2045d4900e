#include "sim/score/consistency.h"

#include <Eigen/Cholesky>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

#include "sim/score/statistics.h"
#include "sim/score/trajectory.h"

namespace sim::score {

std::optional<double> normalised_square(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  const Eigen::LLT<Eigen::Matrix3d> llt(covariance);
  if (llt.info() != Eigen::Success || !covariance.allFinite()) return std::nullopt;
  return error.dot(llt.solve(error));
}

std::optional<PoseNees> pose_nees(const Eigen::Isometry3d& X_WC_true, const Eigen::Isometry3d& X_WC_estimate,
                                  const Matrix6d& covariance) {
  const Eigen::Vector3d turn = rotation_vector(X_WC_estimate.linear().transpose() * X_WC_true.linear());
  const Eigen::Vector3d shift = X_WC_true.translation() - X_WC_estimate.translation();
  const auto orientation = normalised_square(turn, covariance.topLeftCorner<3, 3>());
  const auto position = normalised_square(shift, covariance.bottomRightCorner<3, 3>());
  if (!orientation || !position) return std::nullopt;
  return PoseNees{*orientation, *position};
}

double chi_square_quantile(double p, double dof) {
  return boost::math::quantile(boost::math::chi_squared(dof), p);
}

Band mean_band(int dof, int count, double confidence) {
  const double all = static_cast<double>(dof) * count, tail = (1 - confidence) / 2;
  return {chi_square_quantile(tail, all) / count, chi_square_quantile(1 - tail, all) / count};
}

std::optional<InnovationSummary> summarise(const std::vector<Innovation>& innovations) {
  InnovationSummary summary;
  std::vector<double> z;
  double squares = 0, dof = 0, variance = 0, neighbours = 0;
  for (const Innovation& innovation : innovations) {
    if (innovation.dof <= 0) continue;
    squares += innovation.square;
    dof += innovation.dof;
    z.push_back((innovation.square - innovation.dof) / std::sqrt(2.0 * innovation.dof));
  }
  if (z.size() < 2) return std::nullopt;
  const double about = mean(z);
  for (std::size_t i = 0; i < z.size(); ++i) {
    variance += (z[i] - about) * (z[i] - about);
    if (i > 0) neighbours += (z[i] - about) * (z[i - 1] - about);
  }
  summary.count = static_cast<int>(z.size());
  summary.ratio = squares / dof;
  summary.variance_ratio = variance / summary.count;
  summary.whiteness = variance > 0 ? neighbours / variance : 0;
  summary.band = {chi_square_quantile(0.025, dof) / dof, chi_square_quantile(0.975, dof) / dof};
  return summary;
}

}  // namespace sim::score
