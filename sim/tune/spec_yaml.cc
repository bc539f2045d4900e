#include "sim/tune/spec_yaml.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "sim/bench/scenario_keys.h"

namespace sim::tune {
namespace {

namespace fs = std::filesystem;
using bench::Yaml;

std::uint64_t seed_of(std::string_view text, const Yaml& node) {
  std::uint64_t seed = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (fault != std::errc{} || end != text.data() + text.size())
    fail(node, "seeds", fmt::format("'{}': expected seeds, as in 1..5 or 1,2,7", node.text));
  return seed;
}

bool is_result(const fs::path& folder) { return fs::exists(folder / "recording" / "manifest.csv"); }

// Each folder must hold a finished recording.
void add_folders(const Yaml& at, const fs::path& folder, const std::vector<std::uint64_t>& seeds,
                 Footage& footage) {
  if (seeds.empty()) {
    if (!is_result(folder))
      fail(at, "recordings",
           fmt::format("{} has no finished recording; of a folder of seeds say which: seeds: 1..5",
                       folder.string()));
    footage.folders.push_back(folder);
  }
  for (const std::uint64_t seed : seeds) {
    const fs::path of_seed = folder / fmt::format("seed-{}", seed);
    if (!is_result(of_seed))
      fail(at, "recordings", fmt::format("{} has no finished recording", of_seed.string()));
    footage.folders.push_back(of_seed);
  }
}

// Relative ones are meant from the spec's folder.
std::vector<std::string> paths(const Yaml& node, const fs::path& folder) {
  std::vector<std::string> all = texts(node, "with");
  for (std::string& path : all) path = (folder / path).lexically_normal().string();
  return all;
}

// Another scenario may tell the filter other things, not the walk.
void require_same_walk(const Yaml& at, const Footage& footage, const bench::Scenario& scenario) {
  const bench::Scenario recorded = bench::read_scenario(footage.folders.front() / "scenario.yaml").scenario;
  for (const auto& key : bench::scenario_keys()) {
    if (!shapes_recording(key.name) || !bench::has_section(recorded, key.name)) continue;
    const std::string there = key.print(recorded),
                      here = bench::has_section(scenario, key.name) ? key.print(scenario) : "left out";
    if (there != here)
      fail(at, key.name, fmt::format("is {} in the recordings and {} in the scenario", there, here));
  }
}

Footage read_entry(const Yaml& node, const std::string& key, const fs::path& folder) {
  require_map(node, key, "an entry, as in {scenario: tangent_circle.yaml, seeds: 1..4} or {recordings: DIR}");
  Footage footage;
  const Yaml* recordings = nullptr;
  std::vector<std::uint64_t> seeds;
  for_each_key(node, {"recordings", "seeds", "set", "with", "scenario"},
               [&](const Yaml& at, const Yaml& value) {
                 if (at.text == "recordings") recordings = &value;
                 if (at.text == "recordings" && value.kind != Yaml::Kind::scalar)
                   fail(value, key + ".recordings", "expected a folder of results");
                 if (at.text == "seeds") seeds = read_seeds(value);
                 if (at.text == "set") footage.set = texts(value, "set");
                 if (at.text == "with") footage.with = paths(value, folder);
                 if (at.text == "scenario")
                   footage.scenario = (folder / value.text).lexically_normal().string();
               });
  if (recordings)
    add_folders(*recordings, (folder / recordings->text).lexically_normal(), seeds, footage);
  else if (footage.scenario.empty())
    fail(node, key,
         "expected a scenario, whose recordings the cache has, or recordings, a folder of results");
  else
    footage.seeds = seeds.empty() ? std::vector{bench::read_scenario(footage.scenario).scenario.seed} : seeds;
  const auto scenario = first_scenario_of(footage);  // its faults are told now
  if (recordings) require_same_walk(node, footage, scenario.scenario);
  if (!scenario.scenario.slam) fail(node, key, "the scenario has no filter (slam)");
  return footage;
}

}  // namespace

bench::ReadScenario scenario_of(const Footage& footage, const fs::path& folder) {
  const std::string own = (folder / "scenario.yaml").string();
  if (footage.scenario.empty()) return bench::read_scenario(own, {footage.set, {}, footage.with});
  return scenario_of(footage, bench::read_scenario(own).scenario.seed);
}

bench::ReadScenario scenario_of(const Footage& footage, std::uint64_t seed) {
  std::vector<std::string> set{fmt::format("seed={}", seed)};
  set.insert(set.end(), footage.set.begin(), footage.set.end());
  return bench::read_scenario(footage.scenario, {set, {}, footage.with});
}

bench::ReadScenario first_scenario_of(const Footage& footage) {
  return footage.folders.empty() ? scenario_of(footage, footage.seeds.front())
                                 : scenario_of(footage, footage.folders.front());
}

void require_map(const Yaml& node, std::string_view key, std::string_view example) {
  if (node.kind != Yaml::Kind::map) fail(node, key, fmt::format("expected {}", example));
}

void for_each_key(const Yaml& map, std::initializer_list<std::string_view> known,
                  const std::function<void(const Yaml&, const Yaml&)>& each) {
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const Yaml& key = map.keys[i];
    if (std::find(known.begin(), known.end(), key.text) == known.end())
      fail(key, key.text,
           "unknown key" + bench::did_you_mean(key.text, std::span(known.begin(), known.size())));
    each(key, map.items[i]);
  }
}

bool shapes_recording(std::string_view key) {
  return key.starts_with("walk.") || key.starts_with("stabilizer.") || key.starts_with("world.") ||
         key.starts_with("camera.");
}

std::vector<std::string> texts(const Yaml& node, std::string_view key) {
  if (node.kind != Yaml::Kind::list) fail(node, key, "expected a list, as in [a, b]");
  std::vector<std::string> all;
  for (const Yaml& item : node.items) all.push_back(item.text);
  return all;
}

std::vector<Footage> read_footage(const Yaml& node, const std::string& key, const fs::path& folder) {
  if (node.kind != Yaml::Kind::list || node.items.empty())
    fail(node, key,
         "expected a list of recordings, as in [{recordings: results/tangent_circle, seeds: 1..4}]");
  std::vector<Footage> all;
  for (const Yaml& item : node.items) all.push_back(read_entry(item, key, folder));
  return all;
}

std::vector<std::uint64_t> read_seeds(const Yaml& node) {
  if (node.kind != Yaml::Kind::scalar) fail(node, "seeds", "expected seeds, as in 1..5 or 1,2,7");
  constexpr std::uint64_t kMost = 10000;
  std::vector<std::uint64_t> seeds;
  std::string_view rest = node.text;
  while (true) {
    const std::string_view part = rest.substr(0, rest.find(','));
    const std::size_t dots = part.find("..");
    const std::uint64_t first = seed_of(part.substr(0, dots), node);
    const std::uint64_t last = dots == part.npos ? first : seed_of(part.substr(dots + 2), node);
    if (last < first || last - first >= kMost)
      fail(node, "seeds", fmt::format("'{}': expected a rising range", part));
    for (std::uint64_t seed = first; seed <= last; ++seed) seeds.push_back(seed);
    if (part.size() == rest.size()) return seeds;
    rest.remove_prefix(part.size() + 1);
  }
}

}  // namespace sim::tune
