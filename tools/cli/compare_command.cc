#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>

#include "sim/files/text.h"
#include "sim/scenario/keys.h"
#include "sim/score/metrics.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/verdicts.h"

namespace cli {
namespace {

constexpr const char* kCompareExamples = R"(Examples:
  gaitslam compare results/before results/after --gate rmse_m=10% --gate loop_landmarks=2
Each argument is a result folder, a folder of seed-<n>, or a folder of scenarios with seed-<n>. Common seeds are
paired and compared by the signed rank test. Scenarios with different names or walks need --across, because one may
be harder than the other.
The verdicts and exit codes are those of gaitslam regress.)";

struct CompareRequest {
  fs::path before, after;
  std::vector<std::string> gates;
  VerdictFiles files;
  bool across = false;
};

/// "rmse_m=10%" or "rmse_m=0.002"
regression::Gate parse_gate(const std::string& text) {
  const std::size_t equals = std::min(text.find('='), text.size());
  regression::Gate gate{text.substr(0, equals)};
  if (!score::find_metric(gate.metric))
    throw UsageError("--gate {}: {}", text, scenario::unknown_metric(gate.metric));
  std::string_view number = std::string_view(text).substr(std::min(equals + 1, text.size()));
  const bool percent = number.ends_with('%');
  if (percent) number.remove_suffix(1);
  const auto value = files::parse_finite(number);
  if (!value || *value < 0)
    throw UsageError("--gate {}: expected a tolerance, as in {}=10% or {}=0.002", text, gate.metric,
                     gate.metric);
  (percent ? gate.percent : gate.absolute) = *value;
  return gate;
}

const regression::ResultSet* find(const std::vector<regression::ResultSet>& sets, const std::string& name) {
  for (const regression::ResultSet& set : sets)
    if (set.results.name == name) return &set;
  return nullptr;
}

/// Throws UsageError if two folders contain the same scenario.
std::vector<regression::ResultSet> read_sets(const fs::path& folder) {
  std::vector<regression::ResultSet> sets = regression::read_result_sets(folder);
  for (const regression::ResultSet& set : sets)
    if (const regression::ResultSet* first = find(sets, set.results.name); first != &set)
      throw UsageError("{} and {} contain the same scenario, {}; compare one of them", first->folder.string(),
                       set.folder.string(), set.results.name);
  return sets;
}

/// The folder for a message: of a single result its own, not the one that contains it.
std::string place(const fs::path& argument, const regression::ResultSet& set) {
  return (fs::exists(argument / "score.json") ? argument : set.folder).string();
}

constexpr const char* kInsist = "--across compares different scenarios";

/// Throws UsageError if the names or the walks differ.
void require_same_scenario(const regression::ResultSet& before, const regression::ResultSet& now,
                           const CompareRequest& request) {
  const std::string one = place(request.before, before), two = place(request.after, now);
  if (before.results.name != now.results.name)
    throw UsageError("{} is of the scenario {}, {} of {}; {}", one, before.results.name, two,
                     now.results.name, kInsist);
  auto other = scenario::first_difference(before.scenario, now.scenario);
  if (!other) other = scenario::first_difference(now.scenario, before.scenario);
  if (other)
    throw UsageError("{} and {}: {} differs, so the walks are different scenarios; {}", one, two, other->key,
                     kInsist);
}

/// Throws UsageError unless the scenarios are the same and have at least one in common.
void require_comparable(const std::vector<regression::ResultSet>& before,
                        const std::vector<regression::ResultSet>& now, const CompareRequest& request) {
  if (before.size() == 1 && now.size() == 1)
    return require_same_scenario(before.front(), now.front(), request);
  bool any = false;
  for (const regression::ResultSet& set : now)
    if (const regression::ResultSet* other = find(before, set.results.name)) {
      require_same_scenario(*other, set, request);
      any = true;
    }
  if (!any)
    throw UsageError("{} and {} have no scenario in common; --across compares them anyway",
                     request.before.string(), request.after.string());
}

/// ", my_slam" if an external estimator made the results.
std::string estimators_of(const std::vector<regression::ResultSet>& sets) {
  std::set<std::string> names;
  for (const regression::ResultSet& set : sets) names.insert(set.scenario.estimator.name);
  return names == std::set<std::string>{"filter"} ? "" : fmt::format(", {}", fmt::join(names, ", "));
}

int compare(CompareRequest& request) {
  require_replaceable(request.files);
  if (request.gates.size() > regression::kMostGates)
    throw UsageError("--gate: given {} times, expected at most {}", request.gates.size(),
                     regression::kMostGates);
  std::vector<regression::Gate> gates;
  for (const std::string& text : request.gates) gates.push_back(parse_gate(text));
  if (gates.empty()) gates = regression::default_gates();
  const auto before = read_sets(request.before), now = read_sets(request.after);
  if (!request.across) require_comparable(before, now, request);
  std::vector<regression::ScenarioResults> baseline;
  for (const regression::ResultSet& set : before) baseline.push_back(set.results);
  if (before.size() == 1 && now.size() == 1) baseline.front().name = now.front().results.name;
  std::vector<Judged> judged;
  for (const regression::ResultSet& set : now)
    judged.push_back({set.results, set.scenario, gates, [&](std::uint64_t seed) {
                        const fs::path one = set.folder / fmt::format("seed-{}", seed);
                        return "tools/gaitslam run " +
                               files::shell_word(
                                   ((fs::exists(one) ? one : request.after) / "scenario.yaml").string());
                      }});
  const regression::Comparison comparison{
      fmt::format("gaitslam compare: {} (baseline{}) and {} (now{})", request.before.string(),
                  estimators_of(before), request.after.string(), estimators_of(now)),
      verdicts_of(baseline, judged, gates)};
  for (std::size_t i = 0; i < now.size(); ++i)
    for (const regression::ScenarioResults& other : baseline)
      if (other.name == now[i].results.name && comparison.scenarios[i].n_baseline == 0)
        throw UsageError("{} and {} have no seed in common; run the same seeds of both",
                         request.before.string(), now[i].folder.string());
  report_verdicts(comparison, request.files);
  return regression::exit_code(comparison.scenarios);
}

}  // namespace

void add_compare(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "compare", "Compare two sets of results", kCompareExamples, compare);
  command.add_option("before", request.before, "the folder of results to compare with")->required();
  command.add_option("after", request.after, "the folder of results to judge")->required();
  command.add_option("--gate", request.gates, "a metric and its tolerance, such as rmse_m=10%; repeatable")
      ->allow_extra_args(false);
  command.add_flag("--across", request.across, "compare different scenarios, too");
  add_verdict_files(command, request.files);
}

}  // namespace cli
