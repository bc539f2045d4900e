// A metric: its definition (name, unit, meaning, computation), and its value in one run.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/score/statistics.h"

namespace sim::score {

struct Scored;

/// A number with its unit ("1" for a count or a ratio), or the reason why there is none.
struct Metric {
  std::optional<double> value;
  std::string unit;
  std::string reason;  ///< why there is no value
};
using Metrics = std::map<std::string, Metric, std::less<>>;

/// What a metric's computation gives: a number in the metric's unit, or the reason why there is none.
struct Value {
  Value(double v) : value(v) {}
  static Value none(std::string reason);

  std::optional<double> value;
  std::string reason;
};

/// What a metric is computed from: the walk alone; the estimate; lengths of the estimate, so that its scale
/// must mean something. Where that is missing the metric has no value and is not computed.
enum class Needs { walk, estimate, scale };

inline constexpr bool kHeadline = true;

/// All that is to be said of a metric.
struct MetricDefinition {
  std::string name, unit, definition;  ///< definition: for --help and for reports
  Needs needs = Needs::walk;
  std::function<Value(const Scored&)> compute;
  Direction direction{};  ///< in which it becomes worse
  bool headline = false;  ///< shown in the short table as well
};
using MetricDefinitions = std::vector<MetricDefinition>;

/// The metric of one run, with a value that is finite or with a reason.
Metric compute(const MetricDefinition& definition, const Scored& scored);

}  // namespace sim::score
