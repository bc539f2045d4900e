// The interface of every estimator: the filter, the other built-in ones and external programs.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/estimators/answer.h"
#include "sim/estimators/estimator_choice.h"
#include "slam/observation.h"
#include "slam/options.h"

namespace sim::estimators {

/// Input of an estimator before the first observation.
struct Start {
  slam::Calibration calibration;
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();  ///< of the camera at t = 0, as planned
  std::uint64_t seed = 1;                                  ///< of the run
  slam::Options options = {};                              ///< of the filter
};

/// A running estimator. Exceptions from it are failures of the estimator.
class Estimator {
 public:
  virtual ~Estimator() = default;
  /// Answers an observation; called in the order of arrival.
  virtual Answer step(const slam::Observation& observation) = 0;
  /// Returns the current map.
  virtual std::vector<slam::MapPoint> map() const = 0;
  /// Ends it. Returns what it wrote to its standard error.
  virtual std::string finish() { return {}; }
};

using Step = std::function<Answer(const slam::Observation&)>;

/// Returns an estimator that is a function. Its answers are checked (require_valid()); its map is the latest
/// one in an answer.
std::unique_ptr<Estimator> estimator_from(Step step, std::function<std::string()> finish = {});

/// Names of the built-in estimators, which are values of the scenario's key `estimator`. To add one, write it
/// in estimators.cc.
std::span<const std::string_view> estimator_names();

/// Creates the chosen estimator. Throws std::invalid_argument if its program cannot be started,
/// EstimatorFailed if it fails at its start.
std::unique_ptr<Estimator> make_estimator(const EstimatorChoice& choice, const Start& start);

}  // namespace sim::estimators
