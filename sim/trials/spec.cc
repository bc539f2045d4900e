#include "sim/trials/spec.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <set>

#include "sim/scenario/keys.h"
#include "sim/scenario/recording_key.h"
#include "sim/scenario/value.h"
#include "sim/scenario/yaml_map.h"

namespace sim::trials {
namespace {

namespace fs = std::filesystem;
using scenario::fail;
using scenario::Yaml;
using std::string_view_literals::operator""sv;

constexpr std::array kObjectives{"pose_nll"sv, "innovation_nll"sv, "rmse_m"sv};
constexpr std::size_t kMostRecordings = 100'000;

void require_tunable(const Yaml& at, const std::string& key) {
  if (scenario::shapes_recording(key) || key == "name" || key == "seed")
    fail(at, key, "shapes the recording, which tuning does not change");
  const auto* const known = scenario::find_key(key);
  if (known && !known->expected.starts_with("a number"))
    fail(at, key, fmt::format("is {}, expected a key that is a number", known->expected));
}

std::vector<Range> read_parameters(const Yaml& node) {
  require_map(node, "parameters", "keys with ranges, as in {slam.gyro.sigma_rad_s: {from: 0.001, to: 0.1}}");
  std::vector<Range> all;
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    require_tunable(node.keys[i], node.keys[i].text);
    all.push_back(read_range(node.keys[i], node.items[i]));
    for (const std::string& also : all.back().also) require_tunable(node.items[i], also);
  }
  if (all.empty()) fail(node, "parameters", "is empty, expected at least one key with its range");
  return all;
}

void add_folder(const Yaml& at, const fs::path& folder, std::string_view hint, RecordingSet& set) {
  if (!fs::exists(folder / "recording" / "manifest.csv"))
    fail(at, "recordings", fmt::format("{} has no finished recording{}", folder.string(), hint));
  set.folders.push_back(folder);
}

void add_folders(const Yaml& at, const fs::path& folder, const std::vector<std::uint64_t>& seeds,
                 RecordingSet& set) {
  if (seeds.empty()) add_folder(at, folder, "; choose seeds of a folder of seeds, as in seeds: 1..5", set);
  for (const std::uint64_t seed : seeds) add_folder(at, folder / fmt::format("seed-{}", seed), "", set);
}

void require_same_walk(const Yaml& at, const RecordingSet& set, const scenario::Scenario& scenario) {
  const auto recorded = scenario::read_scenario(set.folders.front() / "scenario.yaml").scenario;
  if (const auto other = scenario::first_difference(recorded, scenario))
    fail(at, other->key,
         fmt::format("is {} in the recordings and {} in the scenario", other->recorded, other->now));
}

RecordingSet read_set(const Yaml& node, const std::string& key, const fs::path& folder) {
  require_map(node, key, "an entry, as in {scenario: tangent_circle.yaml, seeds: 1..4} or {recordings: DIR}");
  RecordingSet set;
  const Yaml* recordings = nullptr;
  std::vector<std::uint64_t> seeds;
  read_map(node, {{"recordings", [&](const Yaml& value) { recordings = &value; }},
                  {"seeds", [&](const Yaml& value) { seeds = read_seeds(value); }},
                  {"set", [&](const Yaml& value) { set.set = read_texts(value, "set", "[seed=2]"); }},
                  {"with",
                   [&](const Yaml& value) {
                     for (const std::string& file : read_texts(value, "with", "[best.yaml]"))
                       set.with.push_back((folder / file).lexically_normal().string());
                   }},
                  {"scenario", [&](const Yaml& value) {
                     set.scenario = read_path(value, "scenario", folder).string();
                   }}});
  if (recordings)
    add_folders(*recordings, read_path(*recordings, key + ".recordings", folder), seeds, set);
  else if (set.scenario.empty())
    fail(node, key, "expected a scenario (recordings of the cache) or recordings (a folder of results)");
  else
    set.seeds = seeds.empty() ? std::vector{scenario::read_scenario(set.scenario).scenario.seed} : seeds;
  const auto scenario = first_scenario_of(set);  // a fault in it is an error of this entry
  if (recordings) require_same_walk(node, set, scenario.scenario);
  if (!scenario.scenario.slam) fail(node, key, "the scenario has no filter (slam)");
  return set;
}

std::vector<RecordingSet> read_sets(const Yaml& node, const std::string& key, const fs::path& folder) {
  if (node.kind != Yaml::Kind::list || node.items.empty())
    fail(node, key,
         "expected a list of recordings, as in [{recordings: results/tangent_circle, seeds: 1..4}]");
  std::vector<RecordingSet> all;
  std::size_t recordings = 0;
  for (const Yaml& item : node.items) {
    all.push_back(read_set(item, key, folder));
    recordings += all.back().folders.size() + all.back().seeds.size();
    if (recordings > kMostRecordings)
      fail(item, key, fmt::format("more than {} recordings", kMostRecordings));
  }
  return all;
}

// A run of one side: the scenario and seed of its replay, and the seed that its walk was recorded with.
struct SeededRun {
  scenario::Scenario scenario;
  std::uint64_t recorded = 0;
};

std::vector<SeededRun> runs_of(const RecordingSet& set) {
  std::vector<SeededRun> all;
  for (const fs::path& folder : set.folders)
    all.push_back(
        {scenario_of(set, folder).scenario, scenario::read_scenario(folder / "scenario.yaml").scenario.seed});
  if (set.seeds.empty()) return all;
  const scenario::Scenario first = first_scenario_of(set).scenario;
  const bool fixed = std::any_of(set.set.begin(), set.set.end(),
                                 [](const std::string& change) { return change.starts_with("seed="); });
  for (const std::uint64_t seed : set.seeds) {
    all.push_back({first, seed});
    if (!fixed) all.back().scenario.seed = seed;
  }
  return all;
}

// Throws ConfigError if a walk of the hold-out is in the training. The same seed on another walk is a
// warning.
void require_unseen(const Yaml& holdout, Spec& spec) {
  std::multimap<std::uint64_t, scenario::Scenario> seen;
  for (const RecordingSet& set : spec.training)
    for (const SeededRun& run : runs_of(set))
      for (const std::uint64_t seed : std::set{run.recorded, run.scenario.seed})
        seen.emplace(seed, run.scenario);
  std::set<std::uint64_t> shared;
  for (std::size_t i = 0; i < spec.holdout.size(); ++i)
    for (const SeededRun& run : runs_of(spec.holdout[i]))
      for (const std::uint64_t seed : std::set{run.recorded, run.scenario.seed})
        for (auto [at, end] = seen.equal_range(seed); at != end; ++at) {
          shared.insert(seed);
          if (!scenario::first_difference(at->second, run.scenario) &&
              !scenario::first_difference(run.scenario, at->second))
            fail(holdout.items[i], "holdout",
                 fmt::format("seed {} of {} is also in the training, expected walks that the search does not "
                             "see",
                             seed, run.scenario.name));
        }
  if (!shared.empty())
    spec.warning =
        fmt::format("training and hold-out share {} on different walks: their sensors draw the same noise",
                    shared.size() == 1 ? fmt::format("seed {}", *shared.begin())
                                       : fmt::format("{} seeds", shared.size()));
}

// Sections that the spec does not have stay empty; required ones are checked at the end.
Spec read_root(const Yaml& root, const fs::path& folder) {
  Spec spec;
  const Yaml* holdout = nullptr;
  const auto value = [](const char* key, const scenario::Domain& domain, auto& into) {
    return std::pair{std::string_view(key), [=, &into](const Yaml& node) { read(node, key, domain, into); }};
  };
  read_map(root,
           {{"parameters", [&](const Yaml& node) { spec.parameters = read_parameters(node); }},
            {"training", [&](const Yaml& node) { spec.training = read_sets(node, "training", folder); }},
            {"holdout",
             [&](const Yaml& node) {
               holdout = &node;
               spec.holdout = read_sets(node, "holdout", folder);
             }},
            value("objective", {0, 0, kObjectives}, spec.objective),
            value("trials", {2, 1e6}, spec.trials),
            value("population", {5, 1000}, spec.population),
            value("seed", {}, spec.seed)});
  if (holdout) require_unseen(*holdout, spec);
  return spec;
}

void require_whole(const Yaml& root, const Spec& spec) {
  if (spec.parameters.empty()) fail(root, "parameters", "missing, expected keys with their ranges");
  if (spec.training.empty())
    fail(root, "training", "missing, expected recordings, as in [{scenario: FILE, seeds: 1..4}]");
  if (spec.holdout.empty())
    fail(root, "holdout",
         "missing, expected recordings that the search does not see, which show whether tuning helps");
  if (spec.trials <= spec.population)
    fail(root, "trials", fmt::format("{} are too few for a population of {}", spec.trials, spec.population));
}

// A parameter without a start gets the value of the first training recording's scenario.
void complete_starts(const Yaml& root, Spec& spec) {
  const scenario::Scenario scenario = first_scenario_of(spec.training.front()).scenario;
  for (Range& p : spec.parameters) {
    if (!std::isnan(p.start)) continue;
    if (!scenario::has_section(scenario, p.key))
      fail(root, p.key, "the recorded scenario has no such section");
    p.start = std::stod(scenario::find_key(p.key)->print(scenario));
    if (p.start < p.low || p.start > p.high)
      fail(root, p.key, fmt::format("starts at {}, outside {} to {}", p.start, p.low, p.high));
  }
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

std::string_view name(Objective objective) { return kObjectives[static_cast<std::size_t>(objective)]; }

Spec read_spec(const fs::path& file) {
  const Yaml root = scenario::parse_yaml_file(file);
  require_map(root, "", "a tuning: {parameters: ..., training: ..., holdout: ...}");
  Spec spec = read_root(root, file.parent_path());
  spec.name = file.stem().string();
  require_whole(root, spec);
  complete_starts(root, spec);
  return spec;
}

}  // namespace sim::trials
