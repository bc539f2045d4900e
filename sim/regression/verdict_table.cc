#include "sim/regression/verdict_table.h"

#include <fmt/format.h>

#include <cmath>

#include "sim/files/number.h"
#include "sim/score/evaluate.h"

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

std::string painted(const std::string& text, bool bad, bool good, bool colour) {
  if (!colour || (!bad && !good)) return text;
  return fmt::format("\033[{}m{}\033[0m", bad ? 31 : 32, text);
}

// Why a row fails and, if there is a run, the command that repeats it.
std::string repro_lines(const Comparison& comparison, const std::string& scenario, std::uint64_t seed,
                        const std::string& why) {
  const std::string repro = comparison.repro(scenario, seed);
  return repro.empty() ? fmt::format("    {}\n", why)
                       : fmt::format("    {}; worst seed {}:\n    {}\n", why, seed, repro);
}

std::string row(const Comparison& comparison, const std::string& scenario, const MetricVerdict& m,
                bool colour) {
  const std::string verdict =
      painted(std::string(word(m.verdict)), fails(m.verdict), m.verdict == Verdict::better, colour);
  std::string text =
      fmt::format("  {:<21} {:>8} {:>8} {:>7} {:>12} {:>6}  {}\n", m.gate.metric, number(m.baseline),
                  number(m.now), change_text(m), band_text(m), p_text(m.p), verdict);
  const std::string remark = m.remark.empty() ? "" : ": " + m.remark;
  if (fails(m.verdict) && m.n > 0)
    text += repro_lines(comparison, scenario, m.worst_seed, "tolerance " + tolerance_text(m.gate) + remark);
  else if (!remark.empty())
    text += "    tolerance " + tolerance_text(m.gate) + remark + "\n";
  return text;
}

std::string row(const Comparison& comparison, const std::string& scenario, const LimitVerdict& limit,
                bool colour) {
  std::string text = fmt::format("  {:<40} {:>25}  {}\n", "limit " + limit.what, limit.observed,
                                 painted(std::string(word(limit)), !limit.passed, false, colour));
  if (!limit.passed)
    text +=
        repro_lines(comparison, scenario, limit.worst_seed, "a limit must be met whatever the baseline says");
  return text;
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

std::string verdict_table(const Comparison& comparison, bool colour) {
  std::string text = comparison.title + "\n";
  for (const ScenarioVerdict& scenario : comparison.scenarios) {
    text += fmt::format("\n{}: {}\n", scenario.name, pairing_text(scenario));
    for (const std::string& difference : scenario.other_config)
      text += fmt::format("  configuration: {}\n", difference);
    text += fmt::format("  {:<21} {:>8} {:>8} {:>7} {:>12} {:>6}  {}\n", "metric", "baseline", "now",
                        "change", "95 % [%]", "p(Holm)", "verdict");
    for (const MetricVerdict& metric : scenario.metrics)
      text += row(comparison, scenario.name, metric, colour);
    for (const LimitVerdict& limit : scenario.limits) text += row(comparison, scenario.name, limit, colour);
  }
  return text + "\n" + count_text(comparison) + "\n";
}

}  // namespace sim::regression
