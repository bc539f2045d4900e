// Metrics of the walk: its heights, its drift from the plan, and how much of it was done.
#pragma once

#include "sim/score/metric.h"

namespace sim::score {

/// Heights, and the drift of the walk from its plan.
MetricDefinitions walk_metrics();
/// How far the robot walked, and which part of the plan was walked and tracked.
MetricDefinitions completion_metrics();

}  // namespace sim::score
