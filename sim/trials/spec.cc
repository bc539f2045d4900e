#include "sim/scenario/keys.h"
#include "sim/trials/tuning.h"

namespace sim::trials {
namespace {

using scenario::fail;
using scenario::Yaml;
using std::string_view_literals::operator""sv;

constexpr std::array kObjectives{"pose_nll"sv, "innovation_nll"sv, "rmse_m"sv};

void require_tunable(const Yaml& at, const std::string& key) {
  if (scenario::shapes_recording(key) || key == "name" || key == "seed")
    fail(at, key, "affects the recording, which tuning does not change");
  const auto* const known = scenario::find_key(key);
  if (known && !known->expected.starts_with("a number"))
    fail(at, key, "is {}, expected a key whose value is a number", known->expected);
}

std::vector<Range> read_parameters(const Yaml& node) {
  require_map(node, "parameters", "keys with ranges, as in {slam.gyro.sigma_rad_s: {from: 0.001, to: 0.1}}");
  std::vector<Range> all;
  for (const auto& [key, range] : node.entries()) {
    require_tunable(key, key.text);
    all.push_back(read_range(key, range));
    for (const std::string& also : all.back().also) require_tunable(range, also);
  }
  if (all.empty()) fail(node, "parameters", "is empty, expected at least one key with its range");
  return all;
}

/// An entry of training or hold-out: recordings replayed with the same changes to their scenario.
struct Entry {
  const Yaml* recordings = nullptr;  ///< a result folder, or a folder of seed-<n>; null: in the cache
  std::string scenario;              ///< the file to replay with; empty: the result's own
  std::vector<std::uint64_t> seeds;
  scenario::Changes changes;

  scenario::ReadScenario read(const std::string& file, std::uint64_t seed) const {
    scenario::Changes all = changes;
    all.overrides.insert(all.overrides.begin(), fmt::format("seed={}", seed));
    return scenario::read_scenario(file, all);
  }
};

Entry read_entry(const Yaml& node, const std::string& key, const fs::path& folder) {
  require_map(node, key, "an entry, as in {scenario: tangent_circle.yaml, seeds: 1..4} or {recordings: DIR}");
  Entry entry;
  read_map(
      node,
      {{"recordings", [&](const Yaml& value) { entry.recordings = &value; }},
       {"seeds", [&](const Yaml& value) { entry.seeds = read_seeds(value); }},
       {"set", [&](const Yaml& value) { entry.changes.overrides = read_texts(value, "set", "[seed=2]"); }},
       {"with",
        [&](const Yaml& value) {
          for (const std::string& file : read_texts(value, "with", "[best.yaml]"))
            entry.changes.with.push_back((folder / file).lexically_normal().string());
        }},
       {"scenario",
        [&](const Yaml& value) { entry.scenario = read_path(value, "scenario", folder).string(); }}});
  if (!entry.recordings && entry.scenario.empty())
    fail(node, key, "expected a scenario (recordings of the cache) or recordings (a folder of results)");
  return entry;
}

SpecRun run_of_result(const Yaml& node, const Entry& entry, const fs::path& folder) {
  if (!fs::exists(folder / "recording" / "manifest.csv"))
    fail(*entry.recordings, "recordings", "{} has no finished recording{}", folder.string(),
         entry.seeds.empty() ? "; if the folder has several seeds, state which, as in seeds: 1..5" : "");
  const fs::path own = folder / "scenario.yaml", whole = fs::absolute(folder / "x").lexically_normal();
  const scenario::Scenario recorded = scenario::read_scenario(own).scenario;
  SpecRun run{(whole.parent_path().parent_path().filename() / whole.parent_path().filename()).string(),
              entry.read(entry.scenario.empty() ? own.string() : entry.scenario, recorded.seed),
              recorded.seed, folder};
  if (const auto other = scenario::first_difference(recorded, run.read.scenario))
    fail(node, other->key, "is {} in the recordings and {} in the scenario", other->recorded, other->now);
  return run;
}

std::vector<SpecRun> read_runs(const Yaml& node, const std::string& key, const fs::path& folder) {
  Entry entry = read_entry(node, key, folder);
  std::vector<SpecRun> runs;
  if (entry.recordings) {
    const fs::path results = read_path(*entry.recordings, key + ".recordings", folder);
    if (entry.seeds.empty()) runs.push_back(run_of_result(node, entry, results));
    for (const std::uint64_t seed : entry.seeds)
      runs.push_back(run_of_result(node, entry, results / fmt::format("seed-{}", seed)));
  } else {
    if (entry.seeds.empty()) entry.seeds = {scenario::read_scenario(entry.scenario).scenario.seed};
    for (const std::uint64_t seed : entry.seeds) {
      runs.push_back({"", entry.read(entry.scenario, seed), seed});
      runs.back().name = fmt::format("{}/seed-{}", runs.back().read.scenario.name, seed);
    }
  }
  if (!runs.front().read.scenario.slam) fail(node, key, "the scenario has no filter (slam)");
  return runs;
}

/// Throws ConfigError if a hold-out run has the same walk and seed as a training run.
void require_unseen(const Yaml& node, const std::vector<SpecRun>& holdout,
                    const std::vector<SpecRun>& training) {
  for (const SpecRun& unseen : holdout)
    for (const SpecRun& seen : training)
      for (const std::uint64_t seed : {unseen.recorded_seed, unseen.read.scenario.seed})
        if ((seed == seen.recorded_seed || seed == seen.read.scenario.seed) &&
            !scenario::first_difference(seen.read.scenario, unseen.read.scenario) &&
            !scenario::first_difference(unseen.read.scenario, seen.read.scenario))
          fail(node, "holdout",
               "seed {} of {} is also in the training, expected walks that the search does not use", seed,
               unseen.read.scenario.name);
}

/// Reads training or hold-out. `seen`: the training that a hold-out must not repeat.
std::vector<SpecRun> read_side(const Yaml& node, const std::string& key, const fs::path& folder,
                               const std::vector<SpecRun>& seen = {}) {
  if (!node.is_list() || node.items.empty())
    fail(node, key,
         "expected a list of recordings, as in [{recordings: results/tangent_circle, seeds: 1..4}]");
  std::vector<SpecRun> all;
  for (const Yaml& item : node.items) {
    std::vector<SpecRun> runs = read_runs(item, key, folder);
    require_unseen(item, runs, seen);
    all.insert(all.end(), runs.begin(), runs.end());
  }
  return all;
}

/// Gives each parameter without a start the value of the first training run.
void complete_starts(const Yaml& root, Spec& spec) {
  const scenario::Scenario& scenario = spec.training.front().read.scenario;
  for (Range& p : spec.parameters) {
    if (!std::isnan(p.start)) continue;
    if (!scenario::has_section(scenario, p.key))
      fail(root, p.key, "the recorded scenario has no such section");
    p.start = std::stod(scenario::find_key(p.key)->print(scenario));
    if (p.start < p.low || p.start > p.high)
      fail(root, p.key, "starts at {}, outside {} to {}", p.start, p.low, p.high);
  }
}

}  // namespace

std::string_view name(Objective objective) { return kObjectives[std::size_t(objective)]; }

Spec read_spec(const fs::path& file) {
  const Yaml root = scenario::parse_yaml_file(file);
  require_map(root, "", "a tuning: {parameters: ..., training: ..., holdout: ...}");
  Spec spec;
  spec.name = file.stem().string();
  const Yaml *training = nullptr, *holdout = nullptr;
  const auto value = [](const char* key, const scenario::Domain& domain, auto& into) {
    return std::pair{std::string_view(key), [=, &into](const Yaml& node) { read(node, key, domain, into); }};
  };
  read_map(root, {{"parameters", [&](const Yaml& node) { spec.parameters = read_parameters(node); }},
                  {"training", [&](const Yaml& node) { training = &node; }},
                  {"holdout", [&](const Yaml& node) { holdout = &node; }},
                  value("objective", {0, 0, kObjectives}, spec.objective),
                  value("trials", {2, 1e6}, spec.trials),
                  value("population", {5, 1000}, spec.population),
                  value("seed", {}, spec.seed)});
  if (spec.parameters.empty()) fail(root, "parameters", "missing, expected keys with their ranges");
  if (!training)
    fail(root, "training", "missing, expected recordings, as in [{scenario: FILE, seeds: 1..4}]");
  spec.training = read_side(*training, "training", file.parent_path());
  if (!holdout)
    fail(root, "holdout",
         "missing, expected recordings that the search does not use, to show whether tuning helps");
  spec.holdout = read_side(*holdout, "holdout", file.parent_path(), spec.training);
  if (spec.trials <= spec.population)
    fail(root, "trials", "{} are too few for a population of {}", spec.trials, spec.population);
  complete_starts(root, spec);
  return spec;
}

}  // namespace sim::trials
