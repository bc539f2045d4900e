// Estimators that can replace the filter, with the same observations and the same score.
#pragma once

#include <span>
#include <string_view>

#include "sim/estimators/estimator.h"
#include "sim/estimators/estimator_choice.h"

namespace sim::estimators {

/// A built-in estimator and its name, a value of the scenario's key `estimator`. make: creates one at the
/// start of a run.
struct NamedEstimator {
  std::string_view name;
  Step (*make)(const Start& start);
};

/// All of them. To add one: write its function in estimators.cc and name it there.
std::span<const NamedEstimator> estimators();

/// The names of the built-in ones: "filter" for slam::Filter, and those of estimators().
std::span<const std::string_view> estimator_names();

/// Makes the chosen estimator; one without a step for the filter. Throws std::invalid_argument where its
/// program or library cannot be started at all (a file that is missing, another version), EstimatorFailed
/// where it fails as it starts.
Estimator make_estimator(const EstimatorChoice& choice, const Start& start);

}  // namespace sim::estimators
