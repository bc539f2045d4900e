// The terms that rate a setting of the filter; one of them is the objective of a tuning.
#pragma once

#include <optional>

#include "sim/score/metrics.h"
#include "sim/score/score_context.h"
#include "sim/tracking/tracking.h"

namespace sim::trials {

/// Losses of one run of the filter.
struct Terms {
  double pose_nll = 0;        ///< mean over scored frames of −ln N(pose error; 0, P), 6 degrees of freedom
  double innovation_nll = 0;  ///< mean over frames of −ln N(innovations; 0, S); needs no truth
  /// |ln(mean NEES / 3)| + |ln(variance of NEES / 6)|, position's plus orientation's
  double consistency = 0;
  double nis_consistency = 0;  ///< |ln NIS ratio| + |ln its variance ratio| over all sensors; needs no truth
  double rmse_m = 0;           ///< of the position, not aligned
};

/// −ln N(error; 0, covariance) of a pose, see score::pose_nees. Returns nullopt unless the covariance is
/// positive definite.
std::optional<double> pose_nll(const Eigen::Isometry3d& X_WC_true, const Eigen::Isometry3d& X_WC_estimate,
                               const score::Matrix6d& covariance);

/// −ln N(innovation; 0, S).
double nll(const slam::Nis& nis);

/// The sum over one frame: internal measurements, also rejected ones, and accepted matches with the noise
/// that the update expects. A landmark that was not found may be anywhere in the image: ln(its pixels).
double innovation_nll(const slam::FrameReport& report, double image_px2);

/// |ln(mean / expected)| + |ln(variance / expected)| of normalized squares (Chen et al. 2018). Only the
/// mean would not detect a filter that is confident at the wrong times.
double consistency(double mean, double expected_mean, double variance, double expected_variance);

/// The terms of a run. Returns nullopt if the filter failed, a covariance is not positive definite or rmse_m
/// has no value.
std::optional<Terms> terms(const score::ScoreContext& scored, const tracking::Tracked& tracked,
                           const score::Metrics& metrics, const slam::CameraIntrinsics& camera);

}  // namespace sim::trials
