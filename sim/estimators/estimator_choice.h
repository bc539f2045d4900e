// The value of the scenario's key `estimator`: a built-in estimator or an external program.
#pragma once

#include "sim/programs/choice.h"

namespace sim::estimators {

using EstimatorChoice = programs::Choice;
using programs::Source;

}  // namespace sim::estimators
