#include "sim/regression/verdict_reports.h"

#include <fmt/format.h>

#include "sim/files/json.h"
#include "sim/result/json.h"

namespace sim::regression {
namespace {

using nlohmann::ordered_json;

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

// Escaped as GitHub requires it of messages and of properties.
std::string escaped(std::string_view text) {
  return replaced(text, {{'%', "%25"}, {'\r', "%0D"}, {'\n', "%0A"}});
}
std::string escaped_property(std::string_view text) {
  return replaced(text, {{'%', "%25"}, {'\r', "%0D"}, {'\n', "%0A"}, {':', "%3A"}, {',', "%2C"}});
}

std::string values_text(const MetricVerdict& m) {
  const auto number = [](const std::optional<double>& v) { return v ? fmt::format("{:.6g}", *v) : "none"; };
  return fmt::format("{} -> {} ({}; tolerance {})", number(m.baseline), number(m.now), change_text(m),
                     tolerance_text(m.gate));
}

// A row of either kind.
struct Line {
  std::string name, message, repro;
  std::string_view verdict;
  bool failed = false, run_failed = false, skipped = false;
};

std::vector<Line> lines_of(const Comparison& comparison, const ScenarioVerdict& scenario) {
  std::vector<Line> all;
  for (const MetricVerdict& m : scenario.metrics)
    all.push_back({m.gate.metric, values_text(m) + (m.remark.empty() ? "" : ": " + m.remark),
                   m.n > 0 ? comparison.repro(scenario.name, m.worst_seed) : "", word(m.verdict),
                   fails(m.verdict), false, m.verdict == Verdict::added});
  for (const LimitVerdict& limit : scenario.limits)
    all.push_back({"limit " + limit.what, "observed: " + limit.observed,
                   limit.passed ? "" : comparison.repro(scenario.name, limit.worst_seed), word(limit),
                   !limit.passed, limit.run_failed, false});
  return all;
}

std::string testcase(const std::string& scenario, const Line& line) {
  std::string inside;
  const std::string message = fmt::format("{}: {}", line.verdict, line.message);
  if (line.failed)
    inside = fmt::format("<{0} message=\"{1}\">{2}</{0}>", line.run_failed ? "error" : "failure",
                         xml(message), xml(line.repro));
  if (line.skipped) inside = fmt::format("<skipped message=\"{}\"/>", xml(message));
  return fmt::format("  <testcase classname=\"{}\" name=\"{}\">{}<system-out>{}</system-out></testcase>\n",
                     xml(scenario), xml(line.name), inside, xml(message));
}

ordered_json json_of(const MetricVerdict& m) {
  return {{"metric", m.gate.metric},
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
          {"remark", m.remark}};
}

}  // namespace

std::string junit(const Comparison& comparison) {
  std::string cases;
  int tests = 0, failures = 0, errors = 0, skipped = 0;
  for (const ScenarioVerdict& scenario : comparison.scenarios)
    for (const Line& line : lines_of(comparison, scenario)) {
      cases += testcase(scenario.name, line);
      ++tests;
      failures += line.failed && !line.run_failed;
      errors += line.run_failed;
      skipped += line.skipped;
    }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\">\n{}</testsuite>\n",
      xml(comparison.title), tests, failures, errors, skipped, cases);
}

std::string markdown(const Comparison& comparison) {
  std::string text = fmt::format("### {}\n\n{}\n", comparison.title, count_text(comparison));
  for (const ScenarioVerdict& scenario : comparison.scenarios) {
    text += fmt::format("\n**{}**: {}\n\n| metric | verdict | |\n|---|---|---|\n", scenario.name,
                        pairing_text(scenario));
    for (const Line& line : lines_of(comparison, scenario))
      text += fmt::format("| `{}` | {} | {}{} |\n", line.name,
                          line.failed ? fmt::format("**{}**", line.verdict) : line.verdict, line.message,
                          line.failed && !line.repro.empty() ? fmt::format("<br>`{}`", line.repro) : "");
  }
  return text;
}

std::string github_annotations(const Comparison& comparison) {
  std::string text;
  for (const ScenarioVerdict& scenario : comparison.scenarios)
    for (const Line& line : lines_of(comparison, scenario))
      if (line.failed)
        text +=
            fmt::format("::error file={},title={}::{}\n", escaped_property(comparison.file(scenario.name)),
                        escaped_property(fmt::format("{} {}: {}", scenario.name, line.name, line.verdict)),
                        escaped(line.message + "\n" + line.repro));
  return text;
}

std::string verdicts_json(const Comparison& comparison) {
  ordered_json json{{"title", comparison.title}, {"exit_code", exit_code(comparison.scenarios)}};
  json["scenarios"] = ordered_json::array();
  for (const ScenarioVerdict& s : comparison.scenarios) {
    ordered_json entry{{"scenario", s.name},
                       {"paired", s.paired},
                       {"seeds_baseline", s.n_baseline},
                       {"seeds_now", s.n_now},
                       {"recordings_that_differ", s.other_recordings},
                       {"configuration_differences", s.other_config}};
    entry["metrics"] = ordered_json::array();
    for (const MetricVerdict& m : s.metrics) entry["metrics"].push_back(json_of(m));
    entry["limits"] = ordered_json::array();
    for (const LimitVerdict& l : s.limits)
      entry["limits"].push_back({{"limit", l.what}, {"observed", l.observed}, {"passed", l.passed}});
    json["scenarios"].push_back(entry);
  }
  return files::json_text(json, 2) + "\n";
}

}  // namespace sim::regression
