// One run scored: everything that is known of it in, all metrics with units and reasons out.
#pragma once

#include <string_view>

#include "sim/score/metric.h"
#include "sim/score/run.h"

namespace sim::score {

/// All metrics in the order in which they are to be shown.
const MetricDefinitions& metric_definitions();
/// The one of that name, or nullptr.
const MetricDefinition* find_metric(std::string_view name);
/// In which direction that metric becomes worse; towards larger values for a name that is not known.
Direction direction_of(std::string_view name);

/// All metrics of metric_definitions(), each with a value or a reason.
Metrics evaluate(const Run& run);
Metrics evaluate(const Scored& scored);

}  // namespace sim::score
