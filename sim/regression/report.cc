#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/regression/verdict.h"
#include "sim/result/limits.h"
#include "sim/score/metrics.h"

namespace sim::regression {
namespace {

using nlohmann::ordered_json;

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

// " m", or nothing for a count or a ratio.
std::string unit_of(const std::string& metric) {
  const score::MetricDefinition* defined = score::find_metric(metric);
  return defined && defined->unit != "1" ? " " + defined->unit : "";
}

// "10 %", "0.002 m", "10 % or 0.002 m"; "a factor of 1.3" for a metric with an expected value.
std::string tolerance_text(const Gate& gate) {
  if (const auto factor = tolerated_factor(gate)) return fmt::format("a factor of {:.3g}", *factor);
  const std::string percents = fmt::format("{} %", gate.percent),
                    absolute = fmt::format("{}{}", gate.absolute, unit_of(gate.metric));
  if (gate.absolute == 0) return percents;
  return gate.percent == 0 ? absolute : percents + " or " + absolute;
}

// "+27 %"; the change itself if the baseline is 0; "-" without a change.
std::string change_text(const MetricVerdict& metric) {
  if (!metric.change) return "-";
  if (*metric.change == 0) return "0 %";
  return metric.baseline && *metric.baseline != 0 ? percent(*metric.change, *metric.baseline) + " %"
                                                  : fmt::format("{:+.3g}", *metric.change);
}

// "3 seeds paired, the same recordings"
std::string pairing_text(const ScenarioVerdict& s) {
  if (s.n_baseline == 0) return "not in the baseline";
  if (s.n_now == 0) return "only in the baseline";
  const std::string recordings =
      s.other_recordings == 0
          ? "the same recordings"
          : fmt::format("{} differ{} (another walk, renderer or CPU)",
                        files::counted(s.other_recordings, "recording"), s.other_recordings == 1 ? "s" : "");
  return fmt::format("{} paired{}, {}", files::counted(s.n_now, "seed"),
                     s.n_now < kSeedsForTest ? " (a test needs 8)" : "", recordings);
}

using result::Paint;
using result::painted;

std::string repro(const ScenarioVerdict& scenario, std::uint64_t seed) {
  return scenario.repro ? scenario.repro(seed) : "";
}

// worst: the seeds that failing rows of a scenario name, in the order of the rows.
std::string worst_seed(std::uint64_t seed, std::vector<std::uint64_t>& worst) {
  if (std::ranges::find(worst, seed) == worst.end()) worst.push_back(seed);
  return fmt::format("worst seed {}", seed);
}

std::string row(const MetricVerdict& m, bool colors, std::vector<std::uint64_t>& worst) {
  const Paint paint = fails(m.verdict)               ? Paint::bad
                      : m.verdict == Verdict::better ? Paint::good
                                                     : Paint::none;
  const std::string p = !m.p ? "-" : *m.p < 0.001 ? "<0.001" : fmt::format("{:.3f}", *m.p);
  std::string text = fmt::format("  {:<21} {:>8} {:>8} {:>7} {:>12} {:>6}  {}\n", m.gate.metric,
                                 number(m.baseline), number(m.now), change_text(m), band_text(m), p,
                                 painted(std::string(word(m.verdict)), paint, colors));
  const bool has_run = fails(m.verdict) && m.n > 0;
  if (has_run || !m.remark.empty())
    text +=
        fmt::format("    tolerance {}{}{}\n", tolerance_text(m.gate), m.remark.empty() ? "" : ": " + m.remark,
                    has_run ? "; " + worst_seed(m.worst_seed, worst) : "");
  return text;
}

std::string row(const LimitVerdict& limit, bool colors, std::vector<std::uint64_t>& worst) {
  std::string text = fmt::format("  {:<40} {:>25}  {}\n", "limit " + limit.what, limit.observed,
                                 painted(word(limit), limit.passed ? Paint::good : Paint::bad, colors));
  for (const std::string& failure : limit.failures)
    text += fmt::format("    {}\n", failure.substr(0, failure.find('\n')));
  return limit.passed ? text : text + "    " + worst_seed(limit.worst_seed, worst) + "\n";
}

std::string scenario_table(const ScenarioVerdict& scenario, bool colors) {
  std::string text = fmt::format("\n{}: {}\n", scenario.name, pairing_text(scenario));
  for (const std::string& difference : scenario.other_config)
    text += fmt::format("  configuration: {}\n", difference);
  text += fmt::format("  {:<21} {:>8} {:>8} {:>7} {:>12} {:>6}  {}\n", "metric", "baseline", "now", "change",
                      "95 % [%]", "p(Holm)", "verdict");
  std::vector<std::uint64_t> worst;
  for (const MetricVerdict& metric : scenario.metrics) text += row(metric, colors, worst);
  for (const LimitVerdict& limit : scenario.limits) text += row(limit, colors, worst);
  std::string again;
  for (const std::uint64_t seed : worst)
    if (const std::string command = repro(scenario, seed); !command.empty())
      again += fmt::format("    {}\n", command);
  return text + (again.empty() ? "" : "  again:\n") + again;
}

std::string replaced(std::string_view text, const std::vector<std::pair<char, std::string_view>>& table) {
  std::string out;
  for (const char c : text) {
    std::string_view as(&c, 1);
    for (const auto& [from, to] : table)
      if (c == from) as = to;
    out += as;
  }
  return out;
}

std::string xml(std::string_view text) {
  return replaced(text, {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\n', "&#10;"}});
}

// A row of either kind.
struct Line {
  std::string name, message, details;  // details: the command that repeats the run, last lines of failed ones
  std::string verdict;
  bool failed = false, run_failed = false, skipped = false;
};

std::vector<Line> lines_of(const ScenarioVerdict& scenario) {
  std::vector<Line> all;
  for (const MetricVerdict& m : scenario.metrics) {
    const auto number = [&](const std::optional<double>& v) {
      return v ? fmt::format("{:.6g}{}", *v, unit_of(m.gate.metric)) : "none";
    };
    all.push_back(
        {m.gate.metric,
         fmt::format("{} -> {} ({}; tolerance {}){}{}", number(m.baseline), number(m.now), change_text(m),
                     tolerance_text(m.gate), m.remark.empty() ? "" : ": ", m.remark),
         m.n > 0 ? repro(scenario, m.worst_seed) : "", std::string(word(m.verdict)), fails(m.verdict), false,
         m.verdict == Verdict::added});
  }
  for (const LimitVerdict& limit : scenario.limits) {
    Line line{"limit " + limit.what,
              "observed: " + limit.observed,
              limit.passed ? "" : repro(scenario, limit.worst_seed),
              word(limit),
              !limit.passed,
              limit.run_failed,
              false};
    for (const std::string& failure : limit.failures) {
      line.message += "; " + failure.substr(0, failure.find('\n'));
      line.details += (line.details.empty() ? "" : "\n") + failure;
    }
    all.push_back(line);
  }
  return all;
}

// "2 of 14 rows failed"
std::string count_text(const Comparison& comparison) {
  std::size_t rows = 0, failed = 0;
  for (const ScenarioVerdict& scenario : comparison.scenarios)
    for (const Line& line : lines_of(scenario)) ++rows, failed += line.failed;
  return fmt::format("{} of {} failed", failed, files::counted(rows, "row"));
}

std::string testcase(const std::string& scenario, const Line& line, double wall_s) {
  std::string inside;
  const std::string message = fmt::format("{}: {}", line.verdict, line.message);
  if (line.failed)
    inside = fmt::format("<{0} message=\"{1}\">{2}</{0}>", line.run_failed ? "error" : "failure",
                         xml(message), xml(line.details));
  if (line.skipped) inside = fmt::format("<skipped message=\"{}\"/>", xml(message));
  return fmt::format(
      "  <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\">{}<system-out>{}</system-out></testcase>\n",
      xml(scenario), xml(line.name), wall_s, inside, xml(message));
}

}  // namespace

std::string verdict_table(const Comparison& comparison, bool colors) {
  std::string text = comparison.title + "\n";
  for (const ScenarioVerdict& scenario : comparison.scenarios) text += scenario_table(scenario, colors);
  const std::string count = count_text(comparison);
  return text + "\n" + painted(count, count.starts_with("0 ") ? Paint::good : Paint::bad, colors) + "\n";
}

std::string junit(const Comparison& comparison) {
  std::string cases;
  int tests = 0, failures = 0, errors = 0, skipped = 0;
  double wall_s = 0;
  for (const ScenarioVerdict& scenario : comparison.scenarios) {
    double left_s = scenario.wall_s;  // the first row has the time of all runs
    wall_s += left_s;
    for (const Line& line : lines_of(scenario)) {
      cases += testcase(scenario.name, line, std::exchange(left_s, 0));
      ++tests;
      failures += line.failed && !line.run_failed;
      errors += line.run_failed;
      skipped += line.skipped;
    }
  }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" "
      "errors=\"{}\" skipped=\"{}\" time=\"{:.3f}\">\n{}</testsuite>\n",
      xml(comparison.title), tests, failures, errors, skipped, wall_s, cases);
}

std::string markdown(const Comparison& comparison) {
  const auto cell = [](std::string_view text) { return replaced(text, {{'|', "\\|"}, {'\n', " "}}); };
  std::string text = fmt::format("### {}\n\n{}\n", comparison.title, count_text(comparison));
  for (const ScenarioVerdict& scenario : comparison.scenarios) {
    text += fmt::format("\n**{}**: {}\n\n| metric | verdict | |\n|---|---|---|\n", scenario.name,
                        pairing_text(scenario));
    for (const Line& line : lines_of(scenario)) {
      text += fmt::format("| `{0}` | {2}{1}{2} | {3}", line.name, line.verdict, line.failed ? "**" : "",
                          cell(line.message));
      std::istringstream details(line.failed ? line.details : "");
      for (std::string detail; std::getline(details, detail);)
        text += fmt::format("<br>`{}`", replaced(cell(detail), {{'`', "'"}}));
      text += " |\n";
    }
  }
  return text;
}

std::string github_annotations(const Comparison& comparison) {
  // Escaped as GitHub requires for messages and for properties.
  const auto message = [](std::string_view text) {
    return replaced(text, {{'%', "%25"}, {'\r', "%0D"}, {'\n', "%0A"}});
  };
  const auto property = [&](std::string_view text) {
    return replaced(message(text), {{':', "%3A"}, {',', "%2C"}});
  };
  std::string text;
  for (const ScenarioVerdict& scenario : comparison.scenarios)
    for (const Line& line : lines_of(scenario))
      if (line.failed)
        text += fmt::format("::error file={},title={}::{}\n", property(scenario.file),
                            property(fmt::format("{} {}: {}", scenario.name, line.name, line.verdict)),
                            message(line.message + "\n" + line.details));
  return text;
}

std::string verdicts_json(const Comparison& comparison) {
  ordered_json json{{"title", comparison.title}, {"exit_code", exit_code(comparison.scenarios)}};
  json["scenarios"] = ordered_json::array();
  for (const ScenarioVerdict& s : comparison.scenarios) {
    ordered_json entry{{"scenario", s.name},
                       {"seeds_baseline", s.n_baseline},
                       {"seeds_now", s.n_now},
                       {"recordings_that_differ", s.other_recordings},
                       {"configuration_differences", s.other_config},
                       {"wall_s", s.wall_s}};
    entry["metrics"] = ordered_json::array();
    for (const MetricVerdict& m : s.metrics)
      entry["metrics"].push_back({{"metric", m.gate.metric},
                                  {"verdict", word(m.verdict)},
                                  {"seeds", m.n},
                                  {"baseline_median", result::or_null(m.baseline)},
                                  {"now_median", result::or_null(m.now)},
                                  {"change", result::or_null(m.change)},
                                  {"change_band_95", result::or_null(m.band)},
                                  {"p_holm", result::or_null(m.p)},
                                  {"tolerance_percent", m.gate.percent},
                                  {"tolerance_absolute", m.gate.absolute},
                                  {"worst_seed", m.worst_seed},
                                  {"remark", m.remark}});
    entry["limits"] = ordered_json::array();
    for (const LimitVerdict& l : s.limits)
      entry["limits"].push_back(
          {{"limit", l.what}, {"observed", l.observed}, {"passed", l.passed}, {"failures", l.failures}});
    json["scenarios"].push_back(entry);
  }
  return files::json_text(json, 2) + "\n";
}

}  // namespace sim::regression
