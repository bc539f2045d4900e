// An estimator that is a program of its own, spoken to in the messages of gaitslam_estimator.h.
#pragma once

#include "sim/estimators/estimator.h"
#include "sim/estimators/estimator_choice.h"

namespace sim::estimators {

/// Starts the program and waits until it is ready. Throws std::invalid_argument where it cannot be started at
/// all, EstimatorFailed with its last lines where it ends, misses its time limit or answers what is no
/// answer; so does each step.
Estimator program_estimator(const EstimatorChoice& choice, const Start& start);

}  // namespace sim::estimators
