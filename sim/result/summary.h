// Statistics of each metric over the seeds of a scenario, and the limits on them.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "sim/result/limits.h"
#include "sim/result/score_file.h"
#include "sim/result/table_style.h"
#include "sim/scenario/scenario.h"
#include "sim/score/statistics.h"

namespace sim::result {

/// One metric over the seeds for which it is defined. Its worst value is the one nearest to missing the
/// metric's limit; without a limit the worst by the metric's definition, as is that of a metric with an
/// expected value.
struct MetricSummary {
  std::string name, unit;
  score::Summary over_seeds;
  bool limited = false;  ///< a limit is on it, or on an aggregate of it
};

struct Summary {
  std::string scenario;
  std::vector<SeedScore> seeds;
  std::vector<MetricSummary> metrics;
  std::vector<JudgedLimit> limits;  ///< those on aggregates
};

/// Depends on the seeds' scores alone, in the order given.
Summary summarize(const scenario::Scenario& scenario, const std::vector<SeedScore>& seeds);

/// The largest of the seeds' exit codes, and at least 1 if a limit over seeds is missed.
int exit_code(const Summary& summary);

nlohmann::ordered_json to_json(const Summary& summary);
/// Writes summary.json completely or not at all. Throws FileError.
void write_summary(const std::filesystem::path& file, const Summary& summary);

/// Seeds, the headline metrics and those with limits, or all, and limits as a table for the terminal.
std::string summary_table(const Summary& summary, const TableStyle& style = {});

}  // namespace sim::result
