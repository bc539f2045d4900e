// Metrics of the feet: how much they slip, and their shares in the drift of the walk.
#pragma once

#include "sim/score/metric.h"

namespace sim::score {

MetricDefinitions feet_metrics();

}  // namespace sim::score
