// Whether an estimate is as sure as it should be: normalised errors and the bands of the chi-square
// distribution.
#pragma once

#include <Eigen/Geometry>
#include <optional>

namespace sim::score {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Normalised estimation error squared, 3 degrees of freedom each: 3 is expected (Bar-Shalom et al. 2001,
/// sec. 5.4).
struct PoseNees {
  double orientation = 0, position = 0;
};

/// covariance: of the error (Log(R_WC_estimateᵀ R_WC_true) in axes C, p_true − p_estimate in axes W), in this
/// order. No alignment: the poses are compared as they are. Nothing when a block of the covariance is not
/// positive definite.
std::optional<PoseNees> pose_nees(const Eigen::Isometry3d& X_WC_true, const Eigen::Isometry3d& X_WC_estimate,
                                  const Matrix6d& covariance);

/// P(chi² <= x) with `dof` > 0 degrees of freedom.
double chi_square_cdf(double x, double dof);
/// The x of which chi_square_cdf(x, dof) = p, p in (0, 1), to 1e-12 relative.
double chi_square_quantile(double p, double dof);

/// Where the mean of `count` independent normalised squares of `dof` degrees of freedom lies with this
/// confidence.
struct Band {
  double low = 0, high = 0;
};
Band mean_band(int dof, int count, double confidence = 0.95);

}  // namespace sim::score
