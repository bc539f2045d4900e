// The limits of a scenario, judged on one run and over seeds; the statistics of each metric over seeds; and
// tables of both for the terminal.
#pragma once

#include <nlohmann/json.hpp>

#include "sim/result/score_file.h"
#include "sim/scenario/scenario.h"
#include "sim/score/statistics.h"

namespace sim::result {

/// Returns the value as JSON, null if absent.
template <typename T>
nlohmann::ordered_json or_null(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

/// Returns four significant digits, or a dash if the value is absent or not finite.
std::string number_text(const std::optional<double>& value);

/// colors: terminal escape sequences. all_metrics: not only headline metrics and metrics with limits.
struct TableStyle {
  bool colors = false;
  bool all_metrics = false;
};

/// good: passed. bad: missed or failed.
enum class Paint { none, good, bad };

/// Returns the text in green or red, if colors are wanted.
inline std::string painted(const std::string& text, Paint paint, bool colors) {
  if (!colors || paint == Paint::none) return text;
  return (paint == Paint::bad ? "\033[31m" : "\033[32m") + text + "\033[0m";
}

/// Returns a metric's values for the seeds that have one.
std::vector<double> values_of(const std::string& metric, const std::vector<SeedScore>& seeds);

/// Returns the limit's verdict. A missing value misses the limit, or is not judged if the scenario has no
/// filter.
JudgedLimit judge(const scenario::Scenario& scenario, const scenario::MetricLimit& limit,
                  std::optional<double> value);

/// Judges the limits on single runs (limits without an aggregate). value_of: the value of a metric by its
/// name.
std::vector<JudgedLimit> judge_run(const scenario::Scenario& scenario,
                                   const std::function<std::optional<double>(const std::string&)>& value_of);

/// Returns whether the scenario allows this ending.
bool is_allowed(const scenario::Scenario& scenario, scenario::Ending ending);

/// Returns the exit code of a run: 3 if the scenario does not allow its ending, 1 if it missed a limit,
/// otherwise 0.
int exit_code(const scenario::Scenario& scenario, scenario::Ending ending,
              const std::vector<JudgedLimit>& limits);

/// Returns which of several values is the worst: the one closest to missing the limit.
score::Worst worst_side(const scenario::MetricLimit& limit);

/// Returns "ok", "MISSED" or "not judged" for tables, in green or red if colors are wanted.
std::string verdict_text(std::optional<bool> passed, bool colors);

/// Returns {"metric": "ate_se3_rmse_m.median", "at_most": 0.1, "value": 0.2, "passed": false}.
nlohmann::ordered_json to_json(const JudgedLimit& judged);

/// One metric over the seeds that have a value. The worst value is the one closest to missing the metric's
/// limit. Without a limit, and for a metric with an expected value, the metric's definition states which
/// value is the worst.
struct MetricSummary {
  std::string name, unit;
  score::Summary over_seeds;
  bool limited = false;  ///< the metric or an aggregate of it has a limit
};

struct Summary {
  std::string scenario;
  std::vector<SeedScore> seeds;
  std::vector<MetricSummary> metrics;
  std::vector<JudgedLimit> limits;  ///< limits on aggregates
};

/// Returns the summary. It depends only on the seeds' scores, in the given order.
Summary summarize(const scenario::Scenario& scenario, const std::vector<SeedScore>& seeds);

/// Returns the largest of the seeds' exit codes, and at least 1 if a limit over seeds is missed.
int exit_code(const Summary& summary);

nlohmann::ordered_json to_json(const Summary& summary);
/// Writes summary.json completely or not at all. Throws FileError.
void write_summary(const fs::path& file, const Summary& summary);

/// Updates the summary.json next to a new result seed-<n>, if there is one and no other process is writing
/// it, so that it covers all seeds of the same provenance.
void renew_summary(const fs::path& result);

/// Returns a table for the terminal: seeds, headline metrics and metrics with limits (or all), and limits.
std::string summary_table(const Summary& summary, const TableStyle& style = {});

/// Returns a table of the headline metrics and the metrics with limits, or of all, from a result folder. A
/// reason shared by several metrics appears once, below them. The table includes the cause of any ending
/// other than completed, unless `failed` is set because the caller prints it.
std::string score_table(const fs::path& result_folder, const TableStyle& style = {}, bool failed = false);

}  // namespace sim::result
