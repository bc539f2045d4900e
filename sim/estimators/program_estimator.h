// An estimator that is a program of its own: messages of gaitslam_estimator.h over its standard input and
// output.
#pragma once

#include <string>
#include <vector>

#include "sim/estimators/estimator.h"
#include "sim/estimators/estimator_choice.h"

namespace sim::estimators {

/// A program and what messages call it.
struct OutsideProgram {
  std::string called;
  std::vector<std::string> words;  ///< itself and its arguments
};

/// Starts a program, tells it options and start, and keeps the time limits of the choice. Throws
/// std::invalid_argument where it cannot be started at all, EstimatorFailed where it fails; so does each
/// step.
Estimator outside_estimator(const OutsideProgram& program, const EstimatorChoice& choice, const Start& start);

/// outside_estimator() of the program that the choice names.
Estimator program_estimator(const EstimatorChoice& choice, const Start& start);

}  // namespace sim::estimators
