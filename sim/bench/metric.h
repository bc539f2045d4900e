// The metrics of a run: each one's name, unit and meaning, written once for score.json, limits and help.
#pragma once

#include <span>
#include <string_view>

namespace sim::bench {

struct Metric {
  std::string_view name, unit, doc;
};

/// All metrics that score.json may hold, in the order of the table.
std::span<const Metric> metrics();

/// The metric of that name, or nullptr.
const Metric* find_metric(std::string_view name);

}  // namespace sim::bench
