#include "sim/score/evaluate.h"

#include <algorithm>

#include "sim/score/absolute_metrics.h"
#include "sim/score/consistency_metrics.h"
#include "sim/score/feet_metrics.h"
#include "sim/score/landmark_metrics.h"
#include "sim/score/loop_metrics.h"
#include "sim/score/navigation_metrics.h"
#include "sim/score/relative_metrics.h"
#include "sim/score/scored.h"
#include "sim/score/walk_metrics.h"

namespace sim::score {

const MetricDefinitions& metric_definitions() {
  static const MetricDefinitions definitions = [] {
    MetricDefinitions all;
    for (const auto group :
         {absolute_metrics, relative_metrics, end_metrics, walk_metrics, navigation_metrics, feet_metrics,
          loop_metrics, consistency_metrics, landmark_metrics, completion_metrics})
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

Metrics evaluate(const Run& run) { return evaluate(Scored(run)); }

Metrics evaluate(const Scored& scored) {
  Metrics metrics;
  for (const MetricDefinition& defined : metric_definitions())
    metrics.emplace(defined.name, compute(defined, scored));
  return metrics;
}

}  // namespace sim::score
