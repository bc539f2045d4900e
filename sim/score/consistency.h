// Consistency of an estimate: normalised errors squared (NEES, NIS) and confidence intervals of the
// chi-square distribution.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "sim/files/trajectory_file.h"

namespace sim::score {

using files::Matrix6d;

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

/// errorᵀ covariance⁻¹ error; nothing when the covariance is not positive definite.
std::optional<double> normalised_square(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance);

/// The x that a chi-square of `dof` > 0 degrees of freedom does not exceed with probability p in (0, 1).
double chi_square_quantile(double p, double dof);

/// The confidence interval of the mean of `count` independent normalised squares of `dof` degrees of freedom.
struct Band {
  double low = 0, high = 0;
};
Band mean_band(int dof, int count, double confidence = 0.95);

/// One sensor's normalised innovation squared in one frame.
struct Innovation {
  double square = 0;
  int dof = 0;
};

/// One sensor's innovations over a run. ratio: sum of squares by sum of degrees of freedom, 1 expected, in
/// `band` with 95 % confidence if they are independent. variance_ratio: variance of (square − dof) / √(2
/// dof) about its mean, 1 expected. whiteness: correlation of those from one frame to the next, 0 expected,
/// ±1.96/√count with 95 % confidence.
struct InnovationSummary {
  int count = 0;
  double ratio = 0, variance_ratio = 0, whiteness = 0;
  Band band;
};
/// Of those with dof > 0; nothing when they are fewer than two.
std::optional<InnovationSummary> summarise(const std::vector<Innovation>& innovations);

}  // namespace sim::score
