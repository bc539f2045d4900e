#include <fmt/format.h>

#include <charconv>
#include <iostream>
#include <memory>

#include "sim/bench/result_set.h"
#include "sim/bench/scenario_yaml.h"
#include "sim/bench/verdict_reports.h"
#include "sim/score/evaluate.h"
#include "sim/stream/durable_file.h"
#include "tools/cli/commands.h"
#include "tools/cli/suite_run.h"

namespace cli {
namespace {

namespace bench = sim::bench;
namespace fs = std::filesystem;

constexpr const char* kExamples = R"(
Examples:
  gaitslam compare results/before results/after
  gaitslam compare results/before results/after --gate rmse_m=10% --gate loop_landmarks=2
Each is a result folder, a folder of seed-<n>, or a folder of scenarios with these. Seeds in common are
paired (signed rank test); without one in common the sets are compared by the rank sum test.
Verdicts and exit code: as for regress.)";

struct Request {
  fs::path before, after;
  std::vector<std::string> gates;
  std::optional<std::string> json, markdown;
};

/// "rmse_m=10%" or "rmse_m=0.002"
bench::Gate parse_gate(const std::string& text) {
  const std::size_t equals = std::min(text.find('='), text.size());
  bench::Gate gate{text.substr(0, equals)};
  if (!sim::score::find_metric(gate.metric)) {
    std::vector<std::string_view> names;
    for (const auto& metric : sim::score::metric_definitions()) names.push_back(metric.name);
    throw UsageError(
        fmt::format("--gate {}: unknown metric{}", text, bench::did_you_mean(gate.metric, names)));
  }
  const char *begin = text.data() + std::min(equals + 1, text.size()), *end = text.data() + text.size();
  const bool percent = end != begin && end[-1] == '%';
  double value = 0;
  const auto [stop, fault] = std::from_chars(begin, end - percent, value);
  if (fault != std::errc{} || stop != end - percent || !(value >= 0))
    throw UsageError(fmt::format("--gate {}: expected a tolerance, as in {}=10% or {}=0.002", text,
                                 gate.metric, gate.metric));
  (percent ? gate.percent : gate.absolute) = value;
  return gate;
}

std::vector<bench::Gate> gates_of(const Request& request) {
  if (request.gates.empty()) return bench::default_gates();
  if (request.gates.size() > bench::kMostGates)
    throw UsageError(
        fmt::format("--gate: given {} times, expected at most {}", request.gates.size(), bench::kMostGates));
  std::vector<bench::Gate> gates;
  for (const std::string& text : request.gates) gates.push_back(parse_gate(text));
  return gates;
}

const bench::ResultSet* find(const std::vector<bench::ResultSet>& sets, const std::string& name) {
  for (const bench::ResultSet& set : sets)
    if (set.results.name == name) return &set;
  return nullptr;
}

bench::ScenarioVerdict judge(const bench::ResultSet* before, const bench::ResultSet& now,
                             const std::vector<bench::Gate>& gates) {
  bench::ScenarioVerdict verdict =
      before ? bench::compare(before->results, now.results, gates)
             : bench::without_counterpart(now.results, gates, bench::Verdict::added);
  verdict.limits = bench::judge_limits(now.scenario, now.results.seeds);
  return verdict;
}

int compare(const Request& request) {
  const auto gates = gates_of(request);
  const auto before = bench::read_result_sets(request.before), now = bench::read_result_sets(request.after);
  bench::Comparison comparison{
      fmt::format("gaitslam compare: {} (baseline) and {} (now)", request.before.string(),
                  request.after.string()),
      {},
      [](const std::string& name) { return name; },
      [&](const std::string& name, std::uint64_t seed) {
        const bench::ResultSet* set = find(now, name);
        if (!set) return std::string();
        const fs::path one = set->folder / fmt::format("seed-{}", seed);
        return "tools/gaitslam run " +
               shell_word(((fs::exists(one) ? one : request.after) / "scenario.yaml").string());
      }};
  const bool one_of_each = before.size() == 1 && now.size() == 1;
  for (const bench::ResultSet& set : now)
    comparison.scenarios.push_back(
        judge(one_of_each ? &before.front() : find(before, set.results.name), set, gates));
  for (const bench::ResultSet& set : before)
    if (!one_of_each && !find(now, set.results.name))
      comparison.scenarios.push_back(bench::without_counterpart(set.results, gates, bench::Verdict::missing));
  std::cout << bench::verdict_table(comparison, colours());
  if (request.json) sim::stream::write_durably(*request.json, bench::verdicts_json(comparison));
  if (request.markdown) sim::stream::write_durably(*request.markdown, bench::markdown(comparison));
  return bench::exit_code(comparison.scenarios);
}

}  // namespace

void add_compare(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<Request>();
  CLI::App* command = app.add_subcommand("compare", "Hold one set of results against another");
  command->add_option("before", request->before, "a folder of results")->required();
  command->add_option("after", request->after, "another")->required();
  command->add_option("--gate", request->gates, "a metric and its tolerance: rmse_m=10% or rmse_m=0.002")
      ->allow_extra_args(false);
  command->add_option("--json", request->json, "write the verdicts as JSON to a file");
  command->add_option("--markdown", request->markdown, "write a Markdown table to a file");
  command->footer(kExamples);
  command->callback([request, &exit_code] { exit_code = compare(*request); });
}

}  // namespace cli
