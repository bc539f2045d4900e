// An estimator in a shared library that exports the functions of gaitslam_estimator.h.
#pragma once

#include "sim/estimators/estimator.h"
#include "sim/estimators/estimator_choice.h"

namespace sim::estimators {

/// Loads the library and creates its estimator. Throws std::invalid_argument where it cannot be loaded or is
/// of another version, EstimatorFailed where it cannot create an estimator; so does each step that fails. It
/// runs in this process, which a crash of it ends: what may crash is better run as a program.
Estimator library_estimator(const EstimatorChoice& choice, const Start& start);

}  // namespace sim::estimators
