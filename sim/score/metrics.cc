#include "sim/score/metrics.h"

#include <fmt/format.h>

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

// "at 3.4 s, 8 % of 43.0 s" if the last moment is not the end of the plan and of the truth.
std::string note_of_end(const MetricDefinition& definition, const ScoreContext& context) {
  const Trajectory &camera = context.run.truth_camera, &waist = context.run.truth_waist;
  const bool of_walk = definition.needs == Needs::walk;
  if (camera.size() < 2 || (of_walk ? waist.empty() : context.pairs.empty())) return "";
  const Stamp last = of_walk ? waist.back().t : context.pairs.back().t, interval = camera[1].t - camera[0].t,
              planned = context.run.planned ? context.run.planned->end : Stamp(0),
              end = std::max(planned, camera.back().t);
  if (last + 2 * interval >= end || last >= end / 100 * 99) return "";
  const double last_s = 1e-9 * static_cast<double>(last.count()),
               end_s = 1e-9 * static_cast<double>(end.count());
  return fmt::format("at {:.1f} s, {:.0f} % of {:.1f} s", last_s, 100 * last_s / end_s, end_s);
}

Metric compute(const MetricDefinition& definition, const ScoreContext& context) {
  const Value found = value(definition, context);
  if (const auto* const absent = std::get_if<Absent>(&found))
    return {std::nullopt, definition.unit, absent->reason};
  const double number = std::get<double>(found);
  if (!std::isfinite(number)) return {std::nullopt, definition.unit, "the value is not finite"};
  return {number, definition.unit, "", definition.at_end ? note_of_end(definition, context) : ""};
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
