#include "sim/score/consistency.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <map>

#include "sim/score/statistics.h"
#include "sim/score/trajectory.h"

namespace sim::score {

std::optional<double> normalized_square(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  const Eigen::LLT<Eigen::Matrix3d> llt(covariance);
  if (llt.info() != Eigen::Success || !covariance.allFinite()) return std::nullopt;
  return error.dot(llt.solve(error));
}

std::optional<PoseNees> pose_nees(const Eigen::Isometry3d& X_WC_true, const Eigen::Isometry3d& X_WC_estimate,
                                  const Matrix6d& covariance) {
  const Eigen::Vector3d turn = rotation_vector(X_WC_estimate.linear().transpose() * X_WC_true.linear());
  const Eigen::Vector3d shift = X_WC_true.translation() - X_WC_estimate.translation();
  const auto orientation = normalized_square(turn, covariance.topLeftCorner<3, 3>());
  const auto position = normalized_square(shift, covariance.bottomRightCorner<3, 3>());
  if (!orientation || !position) return std::nullopt;
  return PoseNees{*orientation, *position};
}

double chi_square_quantile(double p, double dof) {
  return boost::math::quantile(boost::math::chi_squared(dof), p);
}

std::string nis_verdict(double nis) {
  if (nis >= 0.5 && nis <= 2) return "as expected";
  const double factor = std::sqrt(std::max(nis, 1 / nis));
  return fmt::format("its predicted spread is about {:.{}f} times too {}", factor, factor < 3 ? 1 : 0,
                     nis < 1 ? "large" : "small");
}

Band mean_band(int dof, int count, double confidence) {
  const double all = static_cast<double>(dof) * count, tail = (1 - confidence) / 2;
  return {chi_square_quantile(tail, all) / count, chi_square_quantile(1 - tail, all) / count};
}

std::optional<BandFractions> band_fractions(const std::vector<std::vector<double>>& moments, int dof) {
  std::map<std::size_t, Band> bands;  // by the number of runs: a quantile is slow to compute
  std::vector<double> means;
  double inside = 0, below = 0;
  for (const std::vector<double>& squares : moments) {
    if (squares.empty()) continue;
    const auto [band, is_new] = bands.try_emplace(squares.size());
    if (is_new) band->second = mean_band(dof, static_cast<int>(squares.size()));
    means.push_back(mean(squares));
    below += means.back() < band->second.low;
    inside += means.back() >= band->second.low && means.back() <= band->second.high;
  }
  if (means.empty()) return std::nullopt;
  const auto count = static_cast<double>(means.size());
  return BandFractions{mean(means), inside / count, below / count};
}

}  // namespace sim::score
