// Metrics of relative pose errors: over distances, times and footsteps.
#pragma once

#include "sim/score/metric.h"

namespace sim::score {

MetricDefinitions relative_metrics();

}  // namespace sim::score
