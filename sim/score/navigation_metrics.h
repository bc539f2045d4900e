// Metrics of the navigation: how far the robot truly was from the path that its commands describe, and how
// its footsteps were corrected.
#pragma once

#include "sim/score/metric.h"

namespace sim::score {

MetricDefinitions navigation_metrics();

}  // namespace sim::score
