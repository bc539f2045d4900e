// Consistency of an estimate: normalized errors squared (NEES, NIS) and confidence intervals of the
// chi-square distribution.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "sim/files/trajectory_file.h"

namespace sim::score {

using files::Matrix6d;

/// Normalized estimation error squared, 3 degrees of freedom each: 3 is expected (Bar-Shalom et al. 2001,
/// sec. 5.4).
struct PoseNees {
  double orientation = 0, position = 0;
};

/// Returns the NEES without alignment; nothing if a block of the covariance is not positive definite.
/// covariance: of the error (Log(R_WC_estimateᵀ R_WC_true) in axes C, p_true − p_estimate in axes W).
std::optional<PoseNees> pose_nees(const Eigen::Isometry3d& X_WC_true, const Eigen::Isometry3d& X_WC_estimate,
                                  const Matrix6d& covariance);

/// Returns errorᵀ covariance⁻¹ error; nothing if the covariance is not positive definite.
std::optional<double> normalized_square(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance);

/// The quantile for p in (0, 1) of a chi-square of `dof` > 0 degrees of freedom.
double chi_square_quantile(double p, double dof);

/// Returns a verdict on a mean NIS per degree of freedom: "as expected" from 0.5 to 2, else the factor by
/// which the filter's predicted standard deviation of the innovations is wrong.
std::string nis_verdict(double nis);

/// The confidence interval of the mean of `count` independent normalized squares of `dof` degrees of freedom.
struct Band {
  double low = 0, high = 0;
};
Band mean_band(int dof, int count, double confidence = 0.95);

inline constexpr double kSettled_s = 5;  ///< earlier moments are not judged: the start is given

/// Consistency of many runs together. mean: over all moments; inside, below: the fraction of moments with the
/// mean over the runs inside its 95 % confidence interval, or below it.
struct BandFractions {
  double mean = 0, inside = 0, below = 0;
};
/// moments: for each moment the normalized squares (dof degrees of freedom) of the independent runs that have
/// one. Returns nothing if no run has any.
std::optional<BandFractions> band_fractions(const std::vector<std::vector<double>>& moments, int dof);

}  // namespace sim::score
