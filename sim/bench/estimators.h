// Estimators that can be tried beside the filter, on the same observations and by the same score: each is one
// function on an Observation.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "slam/filter.h"
#include "slam/observation.h"
#include "slam/options.h"

namespace sim::bench {

/// Takes an observation in, in the order of arrival, and says where the camera is believed to be by now. One
/// that does not know how sure it is leaves the covariance as it is; its NEES then means nothing.
using Estimator = std::function<slam::Estimate(const slam::Observation&)>;

/// An estimator by the name that the scenario's key `estimator` calls it. make: a new one at the start of a
/// run, which knows what the filter knows then.
struct NamedEstimator {
  std::string_view name;
  Estimator (*make)(const slam::Calibration& calibration, const Eigen::Isometry3d& X_WC_start);
};

/// All of them. To add one: write its function in estimators.cc and name it there.
std::span<const NamedEstimator> estimators();

/// What the scenario's key can be: "filter", the bench's own, and the names of estimators().
std::span<const std::string_view> estimator_names();

}  // namespace sim::bench
