#include "sim/regression/verdict.h"
#include "sim/result/limits.h"
#include "sim/score/metrics.h"

namespace sim::regression {
namespace {

using nlohmann::ordered_json;

using result::number_text;

// Returns a change, or an end of its confidence interval, as a percentage of the baseline.
std::string percent(double change, double baseline) {
  const double part = 100 * change / std::abs(baseline);
  return std::abs(part) < 9.95 ? fmt::format("{:+.1f}", part) : fmt::format("{:+.0f}", part);
}

bool has_percentage(const MetricVerdict& metric) {
  return metric.change && metric.baseline && *metric.baseline != 0;
}

// "[-0.7,+50]"
std::string interval_text(const MetricVerdict& metric) {
  if (!has_percentage(metric) || !metric.band) return "-";
  const auto& [low, high] = *metric.band;
  return fmt::format("[{},{}]", percent(low, *metric.baseline), percent(high, *metric.baseline));
}

// "96.1 %"
std::string covers_text(const MetricVerdict& metric) {
  return interval_text(metric) == "-" ? "-" : fmt::format("{:.1f} %", 100 * metric.coverage);
}

// Returns " m", or nothing for a count or a ratio.
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

// "+27 %"; the change itself if the baseline is 0; "-" if there is no change.
std::string change_text(const MetricVerdict& metric) {
  if (!metric.change) return "-";
  if (*metric.change == 0) return "0 %";
  return has_percentage(metric) ? percent(*metric.change, *metric.baseline) + " %"
                                : fmt::format("{:+.3g}", *metric.change);
}

// "3 seeds paired, the same recordings", or "7 of 8 seeds paired, ..." if a seed has no value.
std::string pairing_text(const ScenarioVerdict& s) {
  if (s.n_baseline == 0) return "not in the baseline";
  if (s.n_now == 0) return "only in the baseline";
  const std::size_t paired =
      s.metrics.empty() ? s.n_now : std::ranges::max(s.metrics, {}, &MetricVerdict::n).n;
  const std::string recordings =
      s.other_recordings == 0
          ? "the same recordings"
          : fmt::format("{} differ{} (a different walk, renderer or CPU)",
                        files::counted(s.other_recordings, "recording"), s.other_recordings == 1 ? "s" : "");
  return fmt::format("{}{} paired{}, {}", paired < s.n_now ? fmt::format("{} of ", paired) : "",
                     files::counted(s.n_now, "seed"), paired < kSeedsForTest ? " (a test needs 8)" : "",
                     recordings);
}

// "coverage: 100 % -> 66.7 % of the true poses"; empty if all of them have an estimate.
std::string coverage_text(const ScenarioVerdict& s) {
  constexpr double kAll = 0.9995;
  if (!s.coverage || (s.coverage->first >= kAll && s.coverage->second >= kAll)) return "";
  return fmt::format("coverage: {:.3g} % -> {:.3g} % of the true poses", 100 * s.coverage->first,
                     100 * s.coverage->second);
}

using result::Paint;
using result::painted;

std::string repro(const ScenarioVerdict& scenario, std::optional<std::uint64_t> seed) {
  return seed && scenario.repro ? scenario.repro(*seed) : "";
}

std::string remedy(const ScenarioVerdict& scenario, const char* before, const char* after = "") {
  return scenario.remedy.empty() ? "" : before + scenario.remedy + after;
}

// How a row counts in the exit code and in each format.
enum class Count { passed, skipped, undecided, failed, run_failed };

Count count_of(Verdict verdict) {
  using enum Count;
  constexpr Count kCounts[]{passed, passed, passed, failed, undecided, skipped, failed};
  return kCounts[std::size_t(verdict)];
}

Count count_of(LimitState state) {
  constexpr Count kCounts[]{Count::passed, Count::failed, Count::undecided, Count::run_failed};
  return kCounts[std::size_t(state)];
}

bool passes(Count count, bool allow_undecided) {
  return count < Count::undecided || (count == Count::undecided && allow_undecided);
}

Paint paint_of(Count count) { return count < Count::undecided ? Paint::good : Paint::bad; }

// worst: the seeds named in failing rows of a scenario, in the order of the rows.
std::string worst_seed(std::uint64_t seed, std::vector<std::uint64_t>& worst) {
  if (std::ranges::find(worst, seed) == worst.end()) worst.push_back(seed);
  return fmt::format("worst seed {}", seed);
}

std::string row(const MetricVerdict& m, bool colors, std::vector<std::uint64_t>& worst) {
  const Count count = count_of(m.verdict);
  const bool is_plain = paint_of(count) == Paint::good && m.verdict != Verdict::better;
  const std::string p = !m.p ? "-" : *m.p < 0.001 ? "<0.001" : fmt::format("{:.3f}", *m.p);
  std::string text =
      fmt::format("  {:<21} {:>8} {:>8} {:>13} {:>6} {:>6}  {}\n", m.gate.metric, number_text(m.baseline),
                  change_text(m), interval_text(m), covers_text(m), p,
                  painted(std::string(word(m.verdict)), is_plain ? Paint::none : paint_of(count), colors));
  const bool has_run = count >= Count::undecided && m.worst_seed;
  if (has_run || !m.remark.empty())
    text +=
        fmt::format("    tolerance {}{}{}\n", tolerance_text(m.gate), m.remark.empty() ? "" : ": " + m.remark,
                    has_run ? "; " + worst_seed(*m.worst_seed, worst) : "");
  return text;
}

std::string row(const LimitVerdict& limit, bool colors, std::vector<std::uint64_t>& worst) {
  std::string text = fmt::format("  {:<40} {:>25}  {}\n", "limit " + limit.what, limit.observed,
                                 painted(word(limit.state), paint_of(count_of(limit.state)), colors));
  for (const std::string& failure : limit.failures)
    text += fmt::format("    {}\n", failure.substr(0, failure.find('\n')));
  return limit.worst_seed ? text + "    " + worst_seed(*limit.worst_seed, worst) + "\n" : text;
}

std::string scenario_table(const ScenarioVerdict& scenario, bool colors) {
  std::string text = fmt::format("\n{}: {}\n", scenario.name, pairing_text(scenario));
  if (const std::string coverage = coverage_text(scenario); !coverage.empty()) text += "  " + coverage + "\n";
  for (const std::string& difference : scenario.other_config)
    text += fmt::format("  configuration: {}\n", difference);
  text += fmt::format("  {:<21} {:>8} {:>8} {:>13} {:>6} {:>6}  {}\n", "metric", "baseline", "change",
                      "interval [%]", "covers", "p(Holm)", "verdict");
  std::vector<std::uint64_t> worst;
  for (const MetricVerdict& metric : scenario.metrics) text += row(metric, colors, worst);
  for (const LimitVerdict& limit : scenario.limits) text += row(limit, colors, worst);
  std::string again;
  for (const std::uint64_t seed : worst)
    if (const std::string command = repro(scenario, seed); !command.empty())
      again += fmt::format("    {}\n", command);
  text += (again.empty() ? "" : "  again:\n") + again;
  if (std::ranges::count(scenario.metrics, Verdict::undecided, &MetricVerdict::verdict) > 0)
    text += remedy(scenario, "  to decide:\n    ", "\n");
  return text;
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
  return replaced(
      text, {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\n', "&#10;"}, {'\t', "&#9;"}});
}

// Removes terminal control characters and characters forbidden in XML from a comparison, because names,
// reasons and commands are arbitrary text.
Comparison sanitized(Comparison comparison) {
  const auto clean = [](std::string& text) { text = files::sanitize(text); };
  clean(comparison.title);
  for (ScenarioVerdict& scenario : comparison.scenarios) {
    clean(scenario.name), clean(scenario.file), clean(scenario.remedy);
    for (MetricVerdict& metric : scenario.metrics) clean(metric.remark);
    for (LimitVerdict& limit : scenario.limits) {
      clean(limit.what), clean(limit.observed);
      std::ranges::for_each(limit.failures, clean);
    }
    std::ranges::for_each(scenario.other_config, clean);
    if (scenario.repro)
      scenario.repro = [repro = scenario.repro](std::uint64_t seed) { return files::sanitize(repro(seed)); };
  }
  return comparison;
}

// Returns text for a Markdown table in which no character is markup.
std::string cell(std::string_view text) {
  return replaced(text, {{'\\', "\\\\"},
                         {'|', "\\|"},
                         {'`', "\\`"},
                         {'*', "\\*"},
                         {'[', "\\["},
                         {'~', "\\~"},
                         {'<', "&lt;"},
                         {'&', "&amp;"},
                         {'\n', " "},
                         {'\t', " "}});
}

// Returns the same as inline code, in which only the cell separator can be escaped, and only if no backslash
// precedes it.
std::string code(std::string_view text) {
  std::string out = replaced(text, {{'`', "'"}, {'\n', " "}, {'\t', " "}});
  for (std::size_t at = 0; (at = out.find('|', at)) != out.npos;) {
    const std::string_view escaped = at > 0 && out[at - 1] == '\\' ? " \\|" : "\\|";
    out.replace(at, 1, escaped);
    at += escaped.size();
  }
  return "`" + out + "`";
}

// A row of either kind. details: the command that repeats the run, and the last lines of failed runs.
struct Line {
  std::string name, message, details, verdict;
  Count count = Count::failed;
};

std::vector<Line> lines_of(const ScenarioVerdict& scenario) {
  std::vector<Line> all;
  for (const MetricVerdict& m : scenario.metrics) {
    const auto number = [&](const std::optional<double>& v) {
      return v ? fmt::format("{:.6g}{}", *v, unit_of(m.gate.metric)) : "none";
    };
    const std::string values = m.change ? fmt::format("{} changes by {}", number(m.baseline), change_text(m))
                                        : fmt::format("{} -> {}", number(m.baseline), number(m.now));
    all.push_back({m.gate.metric,
                   fmt::format("{} (tolerance {}){}{}", values, tolerance_text(m.gate),
                               m.remark.empty() ? "" : ": ", m.remark),
                   repro(scenario, m.worst_seed) +
                       (m.verdict == Verdict::undecided ? remedy(scenario, "\nto decide: ") : ""),
                   std::string(word(m.verdict)), count_of(m.verdict)});
  }
  for (const LimitVerdict& limit : scenario.limits) {
    Line line{"limit " + limit.what, "observed: " + limit.observed, repro(scenario, limit.worst_seed),
              word(limit.state), count_of(limit.state)};
    for (const std::string& failure : limit.failures) {
      line.message += "; " + failure.substr(0, failure.find('\n'));
      line.details += (line.details.empty() ? "" : "\n") + failure;
    }
    all.push_back(line);
  }
  return all;
}

std::size_t count_lines(const Comparison& comparison, Count from, Count to) {
  std::size_t n = 0;
  for (const ScenarioVerdict& scenario : comparison.scenarios)
    for (const Line& line : lines_of(scenario)) n += line.count >= from && line.count <= to;
  return n;
}

// "2 of 14 rows failed, 1 undecided"
std::string count_text(const Comparison& comparison) {
  const std::size_t undecided = count_lines(comparison, Count::undecided, Count::undecided);
  return fmt::format("{} of {} failed{}", count_lines(comparison, Count::failed, Count::run_failed),
                     files::counted(count_lines(comparison, Count::passed, Count::run_failed), "row"),
                     undecided == 0 ? ""
                                    : fmt::format(", {} undecided{}", undecided,
                                                  comparison.allow_undecided ? " (allowed)" : ""));
}

std::string testcase(const std::string& scenario, const Line& line, double wall_s, bool allow_undecided) {
  std::string inside;
  const std::string message = fmt::format("{}: {}", line.verdict, line.message);
  if (!passes(line.count, allow_undecided))
    inside =
        fmt::format("<{0} message=\"{1}\">{2}</{0}>", line.count == Count::run_failed ? "error" : "failure",
                    xml(message), xml(line.details));
  else if (line.count != Count::passed)
    inside = fmt::format("<skipped message=\"{}\"/>", xml(message));
  else
    inside = fmt::format("<system-out>{}</system-out>", xml(message));
  return fmt::format("  <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\">{}</testcase>\n",
                     xml(scenario), xml(line.name), wall_s, inside);
}

}  // namespace

int exit_code(const Comparison& comparison) {
  int worst = 0;
  for (const ScenarioVerdict& scenario : comparison.scenarios)
    for (const Line& line : lines_of(scenario))
      if (!passes(line.count, comparison.allow_undecided))
        worst = std::max(worst, line.count == Count::run_failed ? 3 : 1);
  return worst;
}

std::string verdict_table(const Comparison& raw, bool colors) {
  const Comparison comparison = sanitized(raw);
  std::string text = comparison.title + "\n";
  for (const ScenarioVerdict& scenario : comparison.scenarios) text += scenario_table(scenario, colors);
  return text + "\n" +
         painted(count_text(comparison), exit_code(comparison) == 0 ? Paint::good : Paint::bad, colors) +
         "\n";
}

std::string junit(const Comparison& raw) {
  const Comparison comparison = sanitized(raw);
  std::string cases;
  double wall_s = 0;
  for (const ScenarioVerdict& scenario : comparison.scenarios) {
    double left_s = scenario.wall_s;  // the first row has the time of all runs
    wall_s += left_s;
    for (const Line& line : lines_of(scenario))
      cases += testcase(scenario.name, line, std::exchange(left_s, 0), comparison.allow_undecided);
  }
  const Count allowed = comparison.allow_undecided ? Count::undecided : Count::skipped,
              failure = comparison.allow_undecided ? Count::failed : Count::undecided;
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" "
      "errors=\"{}\" skipped=\"{}\" time=\"{:.3f}\">\n{}</testsuite>\n",
      xml(comparison.title), count_lines(comparison, Count::passed, Count::run_failed),
      count_lines(comparison, failure, Count::failed),
      count_lines(comparison, Count::run_failed, Count::run_failed),
      count_lines(comparison, Count::skipped, allowed), wall_s, cases);
}

std::string markdown(const Comparison& raw) {
  const Comparison comparison = sanitized(raw);
  std::string text = fmt::format("### {}\n\n{}\n", cell(comparison.title), count_text(comparison));
  for (const ScenarioVerdict& scenario : comparison.scenarios) {
    const std::string coverage = coverage_text(scenario);
    text += fmt::format("\n**{}**: {}{}{}\n\n| metric | verdict | |\n|---|---|---|\n", code(scenario.name),
                        pairing_text(scenario), coverage.empty() ? "" : ", ", coverage);
    for (const Line& line : lines_of(scenario)) {
      const bool passed = passes(line.count, comparison.allow_undecided);
      text += fmt::format("| {0} | {2}{1}{2} | {3}", code(line.name), line.verdict, passed ? "" : "**",
                          cell(line.message));
      for (const std::string& detail : files::lines_of(passed ? "" : line.details))
        text += "<br>" + code(detail);
      text += " |\n";
    }
  }
  return text;
}

std::string github_annotations(const Comparison& raw) {
  const Comparison comparison = sanitized(raw);
  // Escaped as GitHub requires for messages and for properties.
  const auto message = [](std::string_view text) { return replaced(text, {{'%', "%25"}, {'\n', "%0A"}}); };
  const auto property = [&](std::string_view text) {
    return replaced(message(text), {{':', "%3A"}, {',', "%2C"}});
  };
  std::string text;
  for (const ScenarioVerdict& scenario : comparison.scenarios)
    for (const Line& line : lines_of(scenario))
      if (line.count >= Count::undecided)
        text += fmt::format("::{} file={},title={}::{}\n",
                            passes(line.count, comparison.allow_undecided) ? "warning" : "error",
                            property(scenario.file),
                            property(fmt::format("{} {}: {}", scenario.name, line.name, line.verdict)),
                            message(line.message + "\n" + line.details));
  return text;
}

std::string verdicts_json(const Comparison& raw) {
  const Comparison comparison = sanitized(raw);
  ordered_json json{{"title", comparison.title}, {"exit_code", exit_code(comparison)}};
  json["scenarios"] = ordered_json::array();
  for (const ScenarioVerdict& s : comparison.scenarios) {
    ordered_json entry{{"scenario", s.name},
                       {"seeds_baseline", s.n_baseline},
                       {"seeds_now", s.n_now},
                       {"recordings_that_differ", s.other_recordings},
                       {"configuration_differences", s.other_config},
                       {"coverage", result::or_null(s.coverage)},
                       {"wall_s", s.wall_s}};
    entry["metrics"] = ordered_json::array();
    for (const MetricVerdict& m : s.metrics)
      entry["metrics"].push_back({{"metric", m.gate.metric},
                                  {"verdict", word(m.verdict)},
                                  {"seeds", m.n},
                                  {"baseline", result::or_null(m.baseline)},
                                  {"now", result::or_null(m.now)},
                                  {"change", result::or_null(m.change)},
                                  {"change_interval", result::or_null(m.band)},
                                  {"interval_coverage", m.band ? ordered_json(m.coverage) : ordered_json()},
                                  {"p_holm", result::or_null(m.p)},
                                  {"tolerance_percent", m.gate.percent},
                                  {"tolerance_absolute", m.gate.absolute},
                                  {"worst_seed", result::or_null(m.worst_seed)},
                                  {"remark", m.remark}});
    entry["limits"] = ordered_json::array();
    for (const LimitVerdict& l : s.limits)
      entry["limits"].push_back({{"limit", l.what},
                                 {"observed", l.observed},
                                 {"passed", passes(count_of(l.state), comparison.allow_undecided)},
                                 {"verdict", word(l.state)},
                                 {"failures", l.failures}});
    json["scenarios"].push_back(entry);
  }
  return files::json_text(json, 2) + "\n";
}

}  // namespace sim::regression
