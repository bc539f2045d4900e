// Estimators that can replace the filter, with the same observations and the same score. Each is one function
// of an Observation.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "slam/filter.h"
#include "slam/observation.h"
#include "slam/options.h"

namespace sim::estimators {

/// Takes the observations in the order of arrival and returns the estimated pose of the camera. An estimator
/// without a covariance leaves it as it is; its NEES then means nothing.
using Estimator = std::function<slam::Estimate(const slam::Observation&)>;

/// An estimator and its name, a value of the scenario's key `estimator`. make: creates one at the start of a
/// run from what the filter is given then.
struct NamedEstimator {
  std::string_view name;
  Estimator (*make)(const slam::Calibration& calibration, const Eigen::Isometry3d& X_WC_start);
};

/// All of them. To add one: write its function in estimators.cc and name it there.
std::span<const NamedEstimator> estimators();

/// The values of the scenario's key `estimator`: "filter" for slam::Filter, and the names of estimators().
std::span<const std::string_view> estimator_names();

}  // namespace sim::estimators
