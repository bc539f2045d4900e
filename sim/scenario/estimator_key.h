// The value of the key `estimator`: a built-in estimator or an external one.
#pragma once

#include <string>
#include <string_view>

#include "sim/estimators/estimator_choice.h"
#include "sim/scenario/value.h"

namespace sim::scenario {

/// expected, read and print of value.h.
std::string expected(const Domain& domain, const estimators::EstimatorChoice&);
void read(const Yaml& node, std::string_view key, const Domain& domain, estimators::EstimatorChoice& choice);
std::string print(const Domain& domain, const estimators::EstimatorChoice& choice);

}  // namespace sim::scenario
