// The one table of metrics: name, unit, meaning and computation of each.
#pragma once

#include <functional>
#include <vector>

#include "sim/score/evaluate.h"
#include "sim/score/metric_values.h"

namespace sim::score {

struct MetricRow {
  MetricDefinition definition;
  std::function<Value(const Scored&)> value;
};

/// In the order in which they are to be shown.
const std::vector<MetricRow>& metric_rows();

}  // namespace sim::score
