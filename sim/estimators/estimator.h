// What every estimator is to the bench: what it is told at the start, and the step that answers an
// observation.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <string>

#include "sim/estimators/pose_estimate.h"
#include "slam/observation.h"
#include "slam/options.h"

namespace sim::estimators {

/// What an estimator is told before the first observation.
struct Start {
  slam::Calibration calibration;
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();  ///< of the camera at t = 0, as planned
  std::uint64_t seed = 1;                                  ///< of the run
};

/// Takes the observations in the order of arrival and answers each. Whatever it throws is a failure of the
/// estimator.
using Step = std::function<Answer(const slam::Observation&)>;

/// An estimator that is running.
struct Estimator {
  Step step;
  /// Ends it. Returns what it wrote to its standard error, if that is known.
  std::function<std::string()> finish = [] { return std::string(); };
};

}  // namespace sim::estimators
