#include "sim/regression/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "sim/files/atomic_file.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/result/json.h"
#include "sim/result/limits.h"
#include "sim/scenario/keys.h"

namespace sim::regression {
namespace {

namespace fs = std::filesystem;

bool is_result(const fs::path& folder) { return fs::exists(folder / "score.json"); }

// The folders below one, by name; only those of results, or all.
std::vector<fs::path> folders_in(const fs::path& folder, bool results) {
  std::vector<fs::path> all;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && (!results || is_result(entry.path()))) all.push_back(entry.path());
  std::sort(all.begin(), all.end());
  return all;
}

ResultSet read_set(const fs::path& folder, const std::vector<fs::path>& results) {
  const scenario::ReadScenario read = scenario::read_scenario(results.front() / "scenario.yaml");
  ResultSet set{{read.scenario.name, config_of(read), {}}, read.scenario, folder};
  for (const fs::path& result : results) set.results.seeds.push_back(read_result(result));
  auto& seeds = set.results.seeds;
  std::sort(seeds.begin(), seeds.end(), [](const auto& a, const auto& b) { return a.seed < b.seed; });
  const auto twice = std::adjacent_find(seeds.begin(), seeds.end(),
                                        [](const auto& a, const auto& b) { return a.seed == b.seed; });
  if (twice != seeds.end()) throw files::FileError(folder, fmt::format("has seed {} twice", twice->seed));
  return set;
}

using nlohmann::ordered_json;
constexpr std::uint64_t kFormat = 1;

// The names of all metrics, in the order of the first seed that has them.
std::vector<std::string> metric_names(const std::vector<result::SeedScore>& seeds) {
  std::vector<std::string> names;
  std::set<std::string> known;
  for (const result::SeedScore& seed : seeds)
    for (const result::SeedMetric& metric : seed.metrics)
      if (known.insert(metric.name).second) names.push_back(metric.name);
  return names;
}

template <class Part>
ordered_json of_seeds(const std::vector<result::SeedScore>& seeds, Part part) {
  ordered_json all = ordered_json::array();
  for (const result::SeedScore& seed : seeds) all.push_back(part(seed));
  return all;
}

// "key": value, a line each.
std::string lines(const ordered_json& object) {
  std::string text;
  for (const auto& [key, value] : object.items())
    text += fmt::format("{}{}: {}", text.empty() ? "" : ",\n", ordered_json(key).dump(), value.dump());
  return text;
}

std::string print(const ScenarioResults& scenario) {
  const auto& seeds = scenario.seeds;
  ordered_json metrics = ordered_json::object();
  for (const std::string& name : metric_names(seeds))
    metrics[name] =
        of_seeds(seeds, [&](const result::SeedScore& s) { return result::or_null(s.value(name)); });
  const ordered_json head{
      {"seeds", of_seeds(seeds, [](const result::SeedScore& s) { return s.seed; })},
      {"recordings_xxh3_128", of_seeds(seeds, [](const result::SeedScore& s) { return s.recording; })}};
  return fmt::format("{}: {{\n\"config\": {{\n{}\n}},\n{},\n\"metrics\": {{\n{}\n}}\n}}",
                     ordered_json(scenario.name).dump(), lines(scenario.config), lines(head), lines(metrics));
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

const result::SeedScore* ScenarioResults::find(std::uint64_t seed) const {
  const auto found =
      std::find_if(seeds.begin(), seeds.end(), [&](const result::SeedScore& s) { return s.seed == seed; });
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

result::SeedScore read_result(const fs::path& folder) {
  result::SeedScore score = result::read_score(folder / "score.json");
  score.recording = files::read_json(folder / "about.json").at("recording_xxh3_128").text();
  const scenario::Scenario scenario = scenario::read_scenario(folder / "scenario.yaml").scenario;
  const auto limits = result::judge_run(scenario, [&](const std::string& name) { return score.value(name); });
  score.exit_code = result::exit_code(scenario, score.ending, limits);
  result::read_details(folder, score);
  return score;
}

std::vector<ResultSet> read_result_sets(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw files::FileError(folder, "not a folder of results");
  if (is_result(folder)) return {read_set(folder.parent_path(), {folder})};
  if (const auto results = folders_in(folder, true); !results.empty()) return {read_set(folder, results)};
  std::vector<ResultSet> sets;
  for (const fs::path& below : folders_in(folder, false))
    if (const auto results = folders_in(below, true); !results.empty())
      sets.push_back(read_set(below, results));
  if (sets.empty()) throw files::FileError(folder, "contains no result, expected seed-<n>/score.json");
  return sets;
}

const ScenarioResults* Baseline::find(const std::string& scenario) const {
  const auto found = std::find_if(scenarios.begin(), scenarios.end(),
                                  [&](const ScenarioResults& s) { return s.name == scenario; });
  return found == scenarios.end() ? nullptr : &*found;
}

Baseline read_baseline(const fs::path& file) {
  if (!fs::exists(file))
    throw files::FileError(file, "does not exist; 'gaitslam baseline update' makes a baseline");
  const files::Json json = files::read_json(file);
  if (const std::uint64_t format = json.at("format_version").whole(); format != kFormat)
    throw files::FileError(file, fmt::format("has format {}, expected {}", format, kFormat));
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
    history += (history.empty() ? "" : ",\n") + json.dump();
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
