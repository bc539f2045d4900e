#include "sim/score/metrics.h"

#include <algorithm>
#include <cmath>

#include "sim/score/score_context.h"

namespace sim::score {
namespace {

Value value(const MetricDefinition& definition, const ScoreContext& context) {
  if (definition.needs == Needs::scale && context.run.no_scale) return Absent{*context.run.no_scale};
  if (definition.needs != Needs::walk && context.no_estimate) return *context.no_estimate;
  return definition.compute(context);
}

Metric compute(const MetricDefinition& definition, const ScoreContext& context) {
  const Value found = value(definition, context);
  if (const auto* const absent = std::get_if<Absent>(&found))
    return {std::nullopt, definition.unit, absent->reason};
  const double number = std::get<double>(found);
  if (!std::isfinite(number)) return {std::nullopt, definition.unit, "the value is not finite"};
  return {number, definition.unit, ""};
}

}  // namespace

const MetricDefinitions& metric_definitions() {
  static const MetricDefinitions definitions = [] {
    MetricDefinitions all;
    for (const auto group :
         {absolute_metrics, relative_metrics, end_metrics, walk_metrics, navigation_metrics, loop_metrics,
          consistency_metrics, landmark_metrics, completion_metrics})
      for (MetricDefinition& definition : group()) all.push_back(std::move(definition));
    return all;
  }();
  return definitions;
}

const MetricDefinition* find_metric(std::string_view name) {
  const auto& all = metric_definitions();
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& m) { return m.name == name; });
  return found == all.end() ? nullptr : &*found;
}

Direction direction_of(std::string_view name) {
  const MetricDefinition* defined = find_metric(name);
  return defined ? defined->direction : Direction();
}

Metrics evaluate(const Run& run) { return evaluate(ScoreContext(run)); }

Metrics evaluate(const ScoreContext& context) {
  Metrics metrics;
  for (const MetricDefinition& defined : metric_definitions())
    metrics.emplace(defined.name, compute(defined, context));
  return metrics;
}

}  // namespace sim::score
