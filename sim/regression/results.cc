#include "sim/regression/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "sim/files/atomic_file.h"
#include "sim/files/hash.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/result/json.h"
#include "sim/result/limits.h"
#include "sim/scenario/keys.h"
#include "sim/score/metrics.h"

namespace sim::regression {
namespace {

namespace fs = std::filesystem;

bool is_result(const fs::path& folder) { return fs::exists(folder / "score.json"); }

// The folders below one, by name.
std::vector<fs::path> folders_in(const fs::path& folder) {
  std::vector<fs::path> all;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory()) all.push_back(entry.path());
  std::sort(all.begin(), all.end());
  return all;
}

std::vector<fs::path> results_in(const fs::path& folder) {
  std::vector<fs::path> all = folders_in(folder);
  std::erase_if(all, [](const fs::path& f) { return !is_result(f); });
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
constexpr std::string_view kSeal = "\"xxh3_128\": \"";
constexpr std::uint64_t kFormat = 1;

std::string hash(std::string_view bytes) {
  files::Hash all;
  all.add(bytes);
  return all.hex();
}

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

ordered_json values(const std::vector<result::SeedScore>& seeds, const std::string& name) {
  return of_seeds(seeds, [&](const result::SeedScore& seed) { return result::or_null(seed.value(name)); });
}

// "key": value, a line each.
std::string lines(const ordered_json& object) {
  std::string text;
  for (const auto& [key, value] : object.items())
    text += fmt::format("{}{}: {}", text.empty() ? "" : ",\n", ordered_json(key).dump(), value.dump());
  return text;
}

std::string print(const ScenarioResults& scenario) {
  ordered_json metrics = ordered_json::object();
  for (const std::string& name : metric_names(scenario.seeds)) metrics[name] = values(scenario.seeds, name);
  const auto& seeds = scenario.seeds;
  const ordered_json head{
      {"config_xxh3_128", config_hash(scenario.config)},
      {"seeds", of_seeds(seeds, [](const result::SeedScore& s) { return s.seed; })},
      {"endings", of_seeds(seeds, [](const result::SeedScore& s) { return scenario::name_of(s.ending); })},
      {"exit_codes", of_seeds(seeds, [](const result::SeedScore& s) { return s.exit_code; })},
      {"recordings_xxh3_128", of_seeds(seeds, [](const result::SeedScore& s) { return s.recording; })}};
  return fmt::format("{}: {{\n\"config\": {{\n{}\n}},\n{},\n\"metrics\": {{\n{}\n}}\n}}",
                     ordered_json(scenario.name).dump(), lines(scenario.config), lines(head), lines(metrics));
}

std::string unit_of_metric(const std::string& name) {
  const score::MetricDefinition* defined = score::find_metric(name);
  return defined ? defined->unit : "";
}

// A list with one item for each of n seeds.
std::vector<files::Json> list_of(const files::Json& list, std::size_t n) {
  std::vector<files::Json> items = list.items();
  if (items.size() != n) list.fail(fmt::format("has {} items, expected {}", items.size(), n));
  return items;
}

int exit_code_from(const files::Json& json) {
  const std::uint64_t code = json.whole();
  if (code > 255) json.fail("expected an exit code up to 255");
  return static_cast<int>(code);
}

ScenarioResults scenario_from(const std::string& name, const files::Json& json) {
  ScenarioResults scenario{name, {}, {}};
  for (const auto& [key, value] : json.at("config").entries()) scenario.config[key] = value.text();
  const auto seeds = json.at("seeds").items();
  const std::size_t n = seeds.size();
  const auto endings = list_of(json.at("endings"), n), codes = list_of(json.at("exit_codes"), n),
             recordings = list_of(json.at("recordings_xxh3_128"), n);
  for (std::size_t i = 0; i < n; ++i)
    scenario.seeds.push_back({seeds[i].whole(),
                              result::read_ending(endings[i]),
                              exit_code_from(codes[i]),
                              {},
                              recordings[i].text()});
  for (const auto& [metric, list] : json.at("metrics").entries()) {
    const auto values = list_of(list, n);
    for (std::size_t i = 0; i < n; ++i)
      scenario.seeds[i].metrics.push_back({metric, unit_of_metric(metric), values[i].number_or_null()});
  }
  return scenario;
}

Baseline from_json(const files::Json& json) {
  Baseline baseline;
  for (const files::Json& change : json.at("history").items())
    baseline.history.push_back(
        {change.at("revision").text(), change.at("reason").text(), change.at("processor").text()});
  for (const auto& [name, scenario] : json.at("scenarios").entries())
    baseline.scenarios.push_back(scenario_from(name, scenario));
  return baseline;
}

void check_seal(const fs::path& file, const std::string& text) {
  const std::size_t seal = text.rfind(kSeal);
  if (seal == text.npos) throw files::FileError(file, "not a baseline file, or truncated");
  if (text.substr(seal) != fmt::format("{}{}\"\n}}\n", kSeal, hash(std::string_view(text).substr(0, seal))))
    throw files::FileError(
        file,
        "was edited after it was written; restore the file, or make a new baseline with 'gaitslam baseline "
        "update'");
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
  if (const auto results = results_in(folder); !results.empty()) return {read_set(folder, results)};
  std::vector<ResultSet> sets;
  for (const fs::path& below : folders_in(folder))
    if (const auto results = results_in(below); !results.empty()) sets.push_back(read_set(below, results));
  if (sets.empty()) throw files::FileError(folder, "contains no result, expected seed-<n>/score.json");
  return sets;
}

const ScenarioResults* Baseline::find(const std::string& scenario) const {
  const auto found = std::find_if(scenarios.begin(), scenarios.end(),
                                  [&](const ScenarioResults& s) { return s.name == scenario; });
  return found == scenarios.end() ? nullptr : &*found;
}

std::string config_hash(const std::map<std::string, std::string>& config) {
  return hash(ordered_json(config).dump());
}

Baseline read_baseline(const fs::path& file) {
  if (!fs::exists(file))
    throw files::FileError(file, "does not exist; 'gaitslam baseline update' makes a baseline");
  const std::string text = files::read_text(file, files::kMostOfJson);
  check_seal(file, text);
  const files::Json json(file, text);
  if (const std::uint64_t format = json.at("format_version").whole(); format != kFormat)
    throw files::FileError(file, fmt::format("has format {}, expected {}", format, kFormat));
  return from_json(json);
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
  std::string text =
      fmt::format("{{\n\"format_version\": {},\n\"history\": [\n{}\n],\n\"scenarios\": {{\n{}\n}},\n",
                  kFormat, history, scenarios);
  text += fmt::format("{}{}\"\n}}\n", kSeal, hash(text));
  if (file.has_parent_path()) fs::create_directories(file.parent_path());
  files::write_atomically(file, text);
}

}  // namespace sim::regression
