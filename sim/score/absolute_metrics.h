// Metrics of absolute errors: of all frames under each alignment, and of the last frame.
#pragma once

#include "sim/score/metric.h"

namespace sim::score {

/// Absolute trajectory errors.
MetricDefinitions absolute_metrics();
/// Errors at the last frame.
MetricDefinitions end_metrics();

}  // namespace sim::score
