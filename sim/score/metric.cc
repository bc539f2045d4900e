#include "sim/score/metric.h"

#include <cmath>

#include "sim/score/scored.h"

namespace sim::score {
namespace {

Value value(const MetricDefinition& definition, const Scored& scored) {
  if (definition.needs == Needs::scale && !scored.run.no_scale.empty())
    return Value::none(scored.run.no_scale);
  if (definition.needs != Needs::walk && !scored.no_estimate.empty()) return Value::none(scored.no_estimate);
  return definition.compute(scored);
}

}  // namespace

Value Value::none(std::string reason) {
  Value none(0);
  none.value.reset();
  none.reason = std::move(reason);
  return none;
}

Metric compute(const MetricDefinition& definition, const Scored& scored) {
  const Value found = value(definition, scored);
  if (found.value && !std::isfinite(*found.value))
    return {std::nullopt, definition.unit, "the value is not finite"};
  return {found.value, definition.unit, found.reason};
}

}  // namespace sim::score
