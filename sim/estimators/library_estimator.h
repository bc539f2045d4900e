// An estimator in a shared library that exports the functions of gaitslam_estimator.h. It runs in a process
// of its own, so that a crash or a hang of it is its failure.
#pragma once

#include <optional>

#include "sim/estimators/estimator.h"
#include "sim/estimators/estimator_choice.h"

namespace sim::estimators {

/// Starts this program again, as the host of the library, and speaks with it as with any program. Throws
/// std::invalid_argument where the library cannot be loaded or is of another version, EstimatorFailed where
/// it cannot create an estimator; so does each step that fails. std::logic_error: main() does not call
/// hosted_library().
Estimator library_estimator(const EstimatorChoice& choice, const Start& start);

/// Call this first in main(), with its arguments. In a process that library_estimator() has started it serves
/// the library until the end of the conversation and returns the exit code; in any other it does nothing.
std::optional<int> hosted_library(int argc, char** argv);

}  // namespace sim::estimators
