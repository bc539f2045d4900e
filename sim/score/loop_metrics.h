// Metrics of the loop closure: whether, when, and what it corrects.
#pragma once

#include "sim/score/metric.h"

namespace sim::score {

MetricDefinitions loop_metrics();

}  // namespace sim::score
