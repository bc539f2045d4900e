// The metrics of a run: what each one means, and its value.
#pragma once

#include <functional>
#include <map>
#include <string_view>

#include "sim/score/statistics.h"

namespace sim::score {

struct Run;
struct ScoreContext;

/// A number with its unit ("1" for a count or a ratio), or the reason why it is absent.
struct Metric {
  std::optional<double> value;
  std::string unit;
  std::string reason;                    ///< why the value is absent
  std::optional<std::string> note = {};  ///< qualification of the value for the reader; see Note
};
using Metrics = std::map<std::string, Metric, std::less<>>;

/// A number in the metric's unit, or the reason why it is absent.
using Value = OrAbsent<double>;

/// The data that a metric needs: only the walk, the estimate, or lengths in the estimate, which require a
/// known scale. Without this input a metric is not computed and has no value.
enum class Needs { walk, estimate, scale };

inline constexpr bool kHeadline = true;

/// The content of a note on the value. at_end: its time, if before the end of the walk · coverage: the
/// fraction of the true poses, if not all · scale: coverage, and the scale of the alignment and why it is not
/// credible, if so.
enum class Note { none, at_end, coverage, scale };

struct MetricDefinition {
  std::string name, unit, definition;  ///< definition: for --help and reports
  Needs needs = Needs::walk;
  std::function<Value(const ScoreContext&)> compute;
  Direction direction{};  ///< which values are worse
  bool headline = false;  ///< shown in the short table as well
  Note note = Note::none;
};
using MetricDefinitions = std::vector<MetricDefinition>;

/// Returns all metrics, in the order of tables and files.
const MetricDefinitions& metric_definitions();
/// Returns the definition of that name, or nullptr.
const MetricDefinition* find_metric(std::string_view name);
/// Returns which values are worse; for an unknown name, larger ones.
Direction direction_of(std::string_view name);

/// Returns all metrics of metric_definitions(), each with a finite value or a reason.
Metrics evaluate(const Run& run);
Metrics evaluate(const ScoreContext& context);

// The groups of metric_definitions() outside metrics.cc.
MetricDefinitions walk_metrics();        ///< heights, drift from the plan, navigation and step corrections
MetricDefinitions loop_metrics();        ///< whether and when the loop was closed, and the errors around it
MetricDefinitions completion_metrics();  ///< path length, and the fraction of plan and time that was tracked
MetricDefinitions map_metrics();         ///< localization in a map of an earlier session
MetricDefinitions timeliness_metrics();  ///< dropped frames, latency and share of the budget

}  // namespace sim::score
