#include "sim/regression/suite.h"

#include <cstdio>
#include <set>

#include "sim/files/atomic_file.h"
#include "sim/result/limits.h"
#include "sim/scenario/keys.h"
#include "sim/score/metrics.h"

namespace sim::regression {
namespace {

using scenario::fail;
using scenario::Yaml;
using std::string_view_literals::operator""sv;

constexpr scenario::Domain kTolerance{0, 1e6}, kFactor{1, 100};
constexpr std::array kSections{"camera"sv, "slam"sv};

Gate read_gate(const Yaml& name, const Yaml& tolerance) {
  const std::string key = "gate." + name.text;
  if (!score::find_metric(name.text)) fail(name, key, scenario::unknown_metric(name.text));
  Gate gate{name.text};
  require_map(tolerance, key, "a tolerance, as in {percent: 10} or {absolute: 0.002}");
  const auto number = [&](const char* part, double& into) {
    return std::pair{std::string_view(part), [&into, key, part](const Yaml& value) {
                       read(value, key + "." + part, kTolerance, into);
                     }};
  };
  read_map(tolerance, {number("percent", gate.percent), number("absolute", gate.absolute)});
  return gate;
}

std::vector<Gate> read_gates(const Yaml& node) {
  require_map(node, "gate", "metrics with tolerances, as in {ate_se3_rmse_m: {percent: 10}}");
  std::vector<Gate> gates;
  for (const auto& [key, value] : node.entries()) gates.push_back(read_gate(key, value));
  if (gates.empty() || gates.size() > kMostGates)
    fail(node, "gate", "has {} metrics, expected 1 to {}", gates.size(), kMostGates);
  return gates;
}

std::vector<std::string> read_without(const Yaml& node) {
  std::vector<std::string> sections = read_texts(node, "without", "[slam]");
  for (std::size_t i = 0; i < sections.size(); ++i)
    if (std::ranges::find(kSections, sections[i]) == kSections.end())
      fail(node.items[i], "without", "'{}', expected camera or slam{}", sections[i],
           scenario::did_you_mean(sections[i], kSections));
  return sections;
}

SuiteEntry read_entry(const Yaml& node, const fs::path& folder) {
  require_map(node, "scenarios", "an entry, as in {scenario: ../tangent_circle.yaml}");
  SuiteEntry entry{.gates = default_gates(), .at = node};
  read_map(node, {{"scenario", [&](const Yaml& value) { entry.file = read_path(value, "scenario", folder); }},
                  {"set",
                   [&](const Yaml& value) {
                     entry.changes.overrides = read_texts(value, "set", "[seed=1]");
                     entry.set = value.items;
                   }},
                  {"without", [&](const Yaml& value) { entry.changes.without = read_without(value); }},
                  {"expect",
                   [&](const Yaml& value) {
                     if (value.text != "limits_missed")
                       fail(value, "expect", "'{}', expected limits_missed", value.text);
                     entry.expects_missed = true;
                   }},
                  {"gate", [&](const Yaml& value) { entry.gates = read_gates(value), entry.at = value; }}});
  if (entry.file.empty()) fail(node, "scenario", "missing, expected a scenario's YAML file");
  return entry;
}

// Moves an error in `set`, "<argument>:n:column: why", to its place in the suite.
std::string name_of(const SuiteEntry& entry) {
  try {
    return scenario::read_scenario(entry.file, entry.changes).scenario.name;
  } catch (const scenario::ConfigError& e) {
    std::size_t n = 0;
    int column = 0, begin = 0;
    if (std::sscanf(e.what(), "<argument>:%zu:%d: %n", &n, &column, &begin) != 2) throw;
    Yaml at = entry.set.at(std::min(n, entry.set.size()) - 1);  // a text may have several lines
    at.origin.column += column - 1;
    fail(at, "set", e.what() + begin);
  }
}

ResultSet read_set(const fs::path& folder, const std::vector<fs::path>& results) {
  const scenario::ReadScenario read = scenario::read_scenario(results.front() / "scenario.yaml");
  ResultSet set{{read.scenario.name, config_of(read), {}}, read.scenario, folder};
  for (const fs::path& result : results) set.results.seeds.push_back(result::read_result(result));
  auto& seeds = set.results.seeds;
  std::ranges::sort(seeds, {}, &result::SeedScore::seed);
  const auto twice = std::ranges::adjacent_find(seeds, {}, &result::SeedScore::seed);
  if (twice != seeds.end()) throw files::FileError(folder, "has seed {} twice", twice->seed);
  return set;
}

using nlohmann::ordered_json;
constexpr std::uint64_t kFormat = 1;

ordered_json of_seeds(const std::vector<result::SeedScore>& seeds, const auto& part) {
  ordered_json all = ordered_json::array();
  for (const result::SeedScore& seed : seeds) all.push_back(part(seed));
  return all;
}

// Returns "key": value, one per line.
std::string lines(const ordered_json& object) {
  std::string text;
  for (const auto& [key, value] : object.items())
    text +=
        fmt::format("{}{}: {}", text.empty() ? "" : ",\n", files::json_text(key), files::json_text(value));
  return text;
}

std::string print(const ScenarioResults& scenario) {
  const auto& seeds = scenario.seeds;
  ordered_json metrics = ordered_json::object();  // in the order of the first seed that has each
  for (const result::SeedScore& seed : seeds)
    for (const result::SeedMetric& metric : seed.metrics)
      if (!metrics.contains(metric.name))
        metrics[metric.name] = of_seeds(
            seeds, [&](const result::SeedScore& s) { return result::or_null(s.value(metric.name)); });
  const ordered_json head{
      {"seeds", of_seeds(seeds, [](const result::SeedScore& s) { return s.seed; })},
      {"recordings_xxh3_128", of_seeds(seeds, [](const result::SeedScore& s) { return s.recording; })}};
  return fmt::format("{}: {{\n\"config\": {{\n{}\n}},\n{},\n\"metrics\": {{\n{}\n}}\n}}",
                     files::json_text(scenario.name), lines(scenario.config), lines(head), lines(metrics));
}

// A list with one item for each of n seeds.
std::vector<files::Json> list_of(const files::Json& list, std::size_t n) {
  std::vector<files::Json> items = list.items();
  if (items.size() != n) list.fail(fmt::format("has {} items, expected {}", items.size(), n));
  return items;
}

ScenarioResults scenario_from(const std::string& name, const files::Json& json) {
  ScenarioResults scenario{name, {}, {}};
  for (const auto& [key, value] : json.at("config").entries()) scenario.config[key] = value.text();
  for (const files::Json& seed : json.at("seeds").items()) scenario.seeds.emplace_back().seed = seed.whole();
  const std::size_t n = scenario.seeds.size();
  const auto recordings = list_of(json.at("recordings_xxh3_128"), n);
  for (std::size_t i = 0; i < n; ++i) scenario.seeds[i].recording = recordings[i].text();
  for (const auto& [metric, list] : json.at("metrics").entries()) {
    const auto values = list_of(list, n);
    for (std::size_t i = 0; i < n; ++i)
      scenario.seeds[i].metrics.push_back({metric, "", values[i].number_or_null()});
  }
  return scenario;
}

}  // namespace

bool is_suite(const fs::path& file) {
  if (!fs::is_regular_file(file)) return false;  // a pipe can be read only once
  const Yaml root = scenario::parse_yaml_file(file);
  return std::ranges::any_of(root.keys, [](const Yaml& key) { return key.text == "scenarios"; });
}

const std::vector<Gate>& default_gates() {
  static const std::vector<Gate> gates{{"ate_se3_rmse_m", 10, 0.001},   {"rmse_m", 15, 0.002},
                                       {"rpe_1m_m", 10, 0.001},         {"end_yaw_error_deg", 20, 0.1},
                                       {"nees_position_mean", 30, 0.5}, {"loop_landmarks", 20, 2}};
  return gates;
}

Suite read_suite(const fs::path& file) {
  const Yaml root = scenario::parse_yaml_file(file);
  require_map(root, "", "a suite: {seeds: 1..3, scenarios: [{scenario: FILE}]}");
  Suite suite{file.stem().string(), "", {}};
  read_map(root,
           {{"seeds",
             [&](const Yaml& value) {
               read_seeds(value);
               suite.seeds = value.text;
             }},
            {"consistent",
             [&](const Yaml& value) { read(value, "consistent", kFactor, suite.consistent.emplace()); }},
            {"scenarios", [&](const Yaml& value) {
               if (!value.is_list()) fail(value, "scenarios", "expected a list of scenarios");
               for (const Yaml& entry : value.items)
                 suite.entries.push_back(read_entry(entry, file.parent_path()));
             }}});
  if (suite.seeds.empty()) fail(root, "seeds", "missing, expected seeds, as in 1..3");
  if (suite.entries.empty()) fail(root, "scenarios", "the suite is empty, expected at least one scenario");
  std::set<std::string> names;
  for (const SuiteEntry& entry : suite.entries)
    if (const auto [name, is_new] = names.insert(name_of(entry)); !is_new)
      throw scenario::ConfigError(fmt::format(
          "{}: two scenarios are called '{}'; set: [name=...] renames one", file.string(), *name));
  return suite;
}

const result::SeedScore* ScenarioResults::find(std::uint64_t seed) const {
  const auto found = std::ranges::find(seeds, seed, &result::SeedScore::seed);
  return found == seeds.end() ? nullptr : &*found;
}

std::map<std::string, std::string> config_of(const scenario::ReadScenario& read) {
  std::map<std::string, std::string> config;
  if (read.scenario.camera) config["camera"] = "present";
  if (read.scenario.slam) config["slam"] = "present";
  for (const auto& [name, origin] : read.origin) {
    const scenario::Key* key = scenario::find_key(name);
    if (name == "name" || name == "seed" || name.starts_with("limits.") || !key) continue;
    if (scenario::has_section(read.scenario, name)) config[name] = key->print(read.scenario);
  }
  return config;
}

std::vector<ResultSet> read_result_sets(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw files::FileError(folder, "not a folder of results");
  std::map<fs::path, std::vector<fs::path>> by_folder;
  for (const fs::path& result : result::find_results(folder))
    by_folder[result.parent_path()].push_back(result);
  if (by_folder.empty()) throw files::FileError(folder, "contains no result, expected seed-<n>/score.json");
  std::vector<ResultSet> sets;
  for (const auto& [parent, results] : by_folder) sets.push_back(read_set(parent, results));
  return sets;
}

const ScenarioResults* Baseline::find(const std::string& scenario) const {
  const auto found = std::ranges::find(scenarios, scenario, &ScenarioResults::name);
  return found == scenarios.end() ? nullptr : &*found;
}

Baseline read_baseline(const fs::path& file) {
  const files::Json json = files::read_json(file);
  if (const std::uint64_t format = json.at("format_version").whole(); format != kFormat)
    throw files::FileError(file, "has format {}, expected {}", format, kFormat);
  Baseline baseline;
  for (const files::Json& change : json.at("history").items())
    baseline.history.push_back(
        {change.at("revision").text(), change.at("reason").text(), change.at("processor").text()});
  for (const auto& [name, scenario] : json.at("scenarios").entries())
    baseline.scenarios.push_back(scenario_from(name, scenario));
  return baseline;
}

void write_baseline(const fs::path& file, const Baseline& baseline) {
  std::string history, scenarios;
  for (const BaselineChange& change : baseline.history) {
    const ordered_json json{
        {"revision", change.revision}, {"reason", change.reason}, {"processor", change.processor}};
    history += (history.empty() ? "" : ",\n") + files::json_text(json);
  }
  for (const ScenarioResults& scenario : baseline.scenarios)
    scenarios += (scenarios.empty() ? "" : ",\n") + print(scenario);
  if (file.has_parent_path()) fs::create_directories(file.parent_path());
  files::write_atomically(
      file,
      fmt::format("{{\n\"format_version\": {},\n\"history\": [\n{}\n],\n\"scenarios\": {{\n{}\n}}\n}}\n",
                  kFormat, history, scenarios));
}

}  // namespace sim::regression
