#include "sim/regression/verdict_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/files/text.h"
#include "sim/result/table_style.h"
#include "sim/score/metrics.h"

namespace sim::regression {
namespace {

std::string number(const std::optional<double>& value) { return value ? fmt::format("{:.4g}", *value) : "-"; }

// A change, or an end of its confidence interval, in percent of the baseline.
std::string percent(double change, double baseline) {
  const double part = 100 * change / std::abs(baseline);
  return std::abs(part) < 9.95 ? fmt::format("{:+.1f}", part) : fmt::format("{:+.0f}", part);
}

std::string band_text(const MetricVerdict& metric) {
  if (!metric.band || !metric.baseline || *metric.baseline == 0) return "-";
  return fmt::format("[{},{}]", percent(metric.band->first, *metric.baseline),
                     percent(metric.band->second, *metric.baseline));
}

std::string p_text(const std::optional<double>& p) {
  return !p ? "-" : *p < 0.001 ? "<0.001" : fmt::format("{:.3f}", *p);
}

using result::Paint;
using result::painted;

// The seeds whose runs failing rows of a scenario name, in the order of the rows.
using WorstSeeds = std::vector<std::uint64_t>;

std::string worst_seed(std::uint64_t seed, WorstSeeds& worst) {
  if (std::find(worst.begin(), worst.end(), seed) == worst.end()) worst.push_back(seed);
  return fmt::format("worst seed {}", seed);
}

// The commands that repeat these runs, each once.
std::string repro_lines(const Comparison& comparison, const std::string& scenario, const WorstSeeds& worst) {
  std::string text;
  for (const std::uint64_t seed : worst)
    if (const std::string repro = comparison.repro(scenario, seed); !repro.empty())
      text += fmt::format("    {}\n", repro);
  return text.empty() ? "" : "  again:\n" + text;
}

std::string row(const MetricVerdict& m, bool colours, WorstSeeds& worst) {
  const Paint paint = fails(m.verdict)               ? Paint::bad
                      : m.verdict == Verdict::better ? Paint::good
                                                     : Paint::none;
  std::string text = fmt::format("  {:<21} {:>8} {:>8} {:>7} {:>12} {:>6}  {}\n", m.gate.metric,
                                 number(m.baseline), number(m.now), change_text(m), band_text(m), p_text(m.p),
                                 painted(std::string(word(m.verdict)), paint, colours));
  const bool has_run = fails(m.verdict) && m.n > 0;
  if (has_run || !m.remark.empty())
    text +=
        fmt::format("    tolerance {}{}{}\n", tolerance_text(m.gate), m.remark.empty() ? "" : ": " + m.remark,
                    has_run ? "; " + worst_seed(m.worst_seed, worst) : "");
  return text;
}

std::string row(const LimitVerdict& limit, bool colours, WorstSeeds& worst) {
  std::string text =
      fmt::format("  {:<40} {:>25}  {}\n", "limit " + limit.what, limit.observed,
                  painted(std::string(word(limit)), limit.passed ? Paint::good : Paint::bad, colours));
  return limit.passed ? text : text + "    " + worst_seed(limit.worst_seed, worst) + "\n";
}

std::string scenario_table(const Comparison& comparison, const ScenarioVerdict& scenario, bool colours) {
  std::string text = fmt::format("\n{}: {}\n", scenario.name, pairing_text(scenario));
  for (const std::string& difference : scenario.other_config)
    text += fmt::format("  configuration: {}\n", difference);
  text += fmt::format("  {:<21} {:>8} {:>8} {:>7} {:>12} {:>6}  {}\n", "metric", "baseline", "now", "change",
                      "95 % [%]", "p(Holm)", "verdict");
  WorstSeeds worst;
  for (const MetricVerdict& metric : scenario.metrics) text += row(metric, colours, worst);
  for (const LimitVerdict& limit : scenario.limits) text += row(limit, colours, worst);
  return text + repro_lines(comparison, scenario.name, worst);
}

bool misses_a_limit(const ScenarioVerdict& scenario) {
  return std::any_of(scenario.limits.begin(), scenario.limits.end(),
                     [](const LimitVerdict& limit) { return !limit.passed; });
}

}  // namespace

std::string tolerance_text(const Gate& gate) {
  const score::MetricDefinition* defined = score::find_metric(gate.metric);
  if (const auto factor = tolerated_factor(gate)) return fmt::format("a factor of {:.3g}", *factor);
  const std::string unit = defined && defined->unit != "1" ? " " + defined->unit : "";
  const std::string percents = fmt::format("{} %", gate.percent),
                    absolute = fmt::format("{}{}", gate.absolute, unit);
  if (gate.absolute == 0) return percents;
  return gate.percent == 0 ? absolute : percents + " or " + absolute;
}

std::string change_text(const MetricVerdict& metric) {
  if (!metric.change) return "-";
  if (*metric.change == 0) return "0 %";
  return metric.baseline && *metric.baseline != 0 ? percent(*metric.change, *metric.baseline) + " %"
                                                  : fmt::format("{:+.3g}", *metric.change);
}

std::string count_text(const Comparison& comparison) {
  std::size_t rows = 0, failed = 0;
  for (const ScenarioVerdict& scenario : comparison.scenarios) {
    rows += scenario.metrics.size() + scenario.limits.size();
    for (const MetricVerdict& metric : scenario.metrics) failed += fails(metric.verdict);
    for (const LimitVerdict& limit : scenario.limits) failed += !limit.passed;
  }
  return fmt::format("{} of {} failed", failed, files::counted(rows, "row"));
}

std::string pairing_text(const ScenarioVerdict& s) {
  if (s.n_baseline == 0) return "not in the baseline";
  if (s.n_now == 0) return "only in the baseline";
  if (!s.paired)
    return fmt::format("no seeds in common: {} and {} compared by the rank sum test", s.n_baseline,
                       files::counted(s.n_now, "seed"));
  const std::string recordings =
      s.other_recordings == 0
          ? "the same recordings"
          : fmt::format("{} differ{} (another walk, renderer or CPU)",
                        files::counted(s.other_recordings, "recording"), s.other_recordings == 1 ? "s" : "");
  return fmt::format("{} paired{}, {}", files::counted(s.n_now, "seed"),
                     s.n_now < kSeedsForTest ? " (a test needs 8)" : "", recordings);
}

std::string verdict_table(const Comparison& comparison, bool colours) {
  std::string text = comparison.title + "\n";
  for (const ScenarioVerdict& scenario : comparison.scenarios)
    text += scenario_table(comparison, scenario, colours);
  text += "\n";
  if (std::any_of(comparison.scenarios.begin(), comparison.scenarios.end(), misses_a_limit))
    text += "A limit must be met whatever the baseline says.\n";
  const std::string count = count_text(comparison);
  return text + painted(count, count.starts_with("0 ") ? Paint::good : Paint::bad, colours) + "\n";
}

}  // namespace sim::regression
