#include "sim/tune/recording_set.h"

#include <fmt/format.h>

#include "sim/tune/recording_key.h"
#include "sim/tune/yaml_map.h"

namespace sim::tune {
namespace {

namespace fs = std::filesystem;
using scenario::Yaml;

constexpr std::size_t kMostRecordings = 100'000;

void add_folder(const Yaml& at, const fs::path& folder, std::string_view hint, RecordingSet& set) {
  if (!fs::exists(folder / "recording" / "manifest.csv"))
    scenario::fail(at, "recordings", fmt::format("{} has no finished recording{}", folder.string(), hint));
  set.folders.push_back(folder);
}

void add_folders(const Yaml& at, const fs::path& folder, const std::vector<std::uint64_t>& seeds,
                 RecordingSet& set) {
  if (seeds.empty()) add_folder(at, folder, "; choose seeds of a folder of seeds, as in seeds: 1..5", set);
  for (const std::uint64_t seed : seeds) add_folder(at, folder / fmt::format("seed-{}", seed), "", set);
}

fs::path from(const fs::path& folder, const std::string& path) { return (folder / path).lexically_normal(); }

std::vector<std::string> read_paths(const Yaml& node, std::string_view key, const fs::path& folder) {
  std::vector<std::string> all = read_texts(node, key);
  for (std::string& path : all) path = from(folder, path).string();
  return all;
}

void require_same_walk(const Yaml& at, const RecordingSet& set, const scenario::Scenario& scenario) {
  const auto recorded = scenario::read_scenario(set.folders.front() / "scenario.yaml").scenario;
  if (const auto other = first_difference(recorded, scenario))
    scenario::fail(
        at, other->key,
        fmt::format("is {} in the recordings and {} in the scenario", other->recorded, other->now));
}

RecordingSet read_set(const Yaml& node, const std::string& key, const fs::path& folder) {
  require_map(node, key, "an entry, as in {scenario: tangent_circle.yaml, seeds: 1..4} or {recordings: DIR}");
  RecordingSet set;
  const Yaml* recordings = nullptr;
  std::vector<std::uint64_t> seeds;
  read_map(node,
           {{"recordings", [&](const Yaml& value) { recordings = &value; }},
            {"seeds", [&](const Yaml& value) { seeds = read_seeds(value); }},
            {"set", [&](const Yaml& value) { set.set = read_texts(value, "set"); }},
            {"with", [&](const Yaml& value) { set.with = read_paths(value, "with", folder); }},
            {"scenario", [&](const Yaml& value) { set.scenario = from(folder, value.text).string(); }}});
  if (recordings && recordings->kind != Yaml::Kind::scalar)
    scenario::fail(*recordings, key + ".recordings", "expected a folder of results");
  if (recordings)
    add_folders(*recordings, from(folder, recordings->text), seeds, set);
  else if (set.scenario.empty())
    scenario::fail(node, key,
                   "expected a scenario, whose recordings the cache has, or recordings, a folder of results");
  else
    set.seeds = seeds.empty() ? std::vector{scenario::read_scenario(set.scenario).scenario.seed} : seeds;
  const auto scenario = first_scenario_of(set);  // a fault of it is an error of this entry
  if (recordings) require_same_walk(node, set, scenario.scenario);
  if (!scenario.scenario.slam) scenario::fail(node, key, "the scenario has no filter (slam)");
  return set;
}

}  // namespace

scenario::ReadScenario scenario_of(const RecordingSet& set, const fs::path& folder) {
  const std::string own = (folder / "scenario.yaml").string();
  if (set.scenario.empty()) return scenario::read_scenario(own, {set.set, {}, set.with});
  return scenario_of(set, scenario::read_scenario(own).scenario.seed);
}

scenario::ReadScenario scenario_of(const RecordingSet& set, std::uint64_t seed) {
  std::vector<std::string> changes{fmt::format("seed={}", seed)};
  changes.insert(changes.end(), set.set.begin(), set.set.end());
  return scenario::read_scenario(set.scenario, {changes, {}, set.with});
}

scenario::ReadScenario first_scenario_of(const RecordingSet& set) {
  return set.folders.empty() ? scenario_of(set, set.seeds.front()) : scenario_of(set, set.folders.front());
}

std::vector<RecordingSet> read_recording_sets(const Yaml& node, const std::string& key,
                                              const fs::path& folder) {
  if (node.kind != Yaml::Kind::list || node.items.empty())
    scenario::fail(
        node, key,
        "expected a list of recordings, as in [{recordings: results/tangent_circle, seeds: 1..4}]");
  std::vector<RecordingSet> all;
  std::size_t recordings = 0;
  for (const Yaml& item : node.items) {
    all.push_back(read_set(item, key, folder));
    recordings += all.back().folders.size() + all.back().seeds.size();
    if (recordings > kMostRecordings)
      scenario::fail(item, key, fmt::format("more than {} recordings", kMostRecordings));
  }
  return all;
}

}  // namespace sim::tune
