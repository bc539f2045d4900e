// Metrics of the final map's landmarks.
#pragma once

#include "sim/score/metric.h"

namespace sim::score {

MetricDefinitions landmark_metrics();

}  // namespace sim::score
