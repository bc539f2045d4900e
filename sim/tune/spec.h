// What a tuning is asked to do: one YAML file, read strictly.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/bench/scenario.h"
#include "sim/bench/scenario_yaml.h"

namespace sim::tune {

/// A number of the scenario that is looked for. Between 0 and 1 it goes from low to high, by its logarithm
/// or linearly.
struct Parameter {
  std::string key;                ///< of the one table of keys
  std::vector<std::string> also;  ///< keys that get the same value
  double low = 0, high = 1, start = 0;
  bool logarithmic = true;

  double at(double part) const;  ///< part in [0, 1]
  double part_of(double value) const;
};

/// What settings are judged by, see Terms.
enum class Objective { pose_nll, innovation_nll, consistency, nis_consistency, rmse_m };
/// Their names in a spec, in order; also the names of their values in a trial's record.
std::span<const std::string_view> objective_names();
std::string_view name(Objective objective);

enum class Optimiser { cma_es, differential_evolution, nsga_ii };

/// Recordings to try a setting on: one result folder, seeds of a folder that holds seed-<n>, or seeds of a
/// scenario whose recordings the cache has.
struct Footage {
  std::vector<std::filesystem::path> folders;  ///< result folders; of the cache: empty until taken from there
  std::vector<std::uint64_t> seeds;            ///< of recordings from the cache
  std::vector<std::string> set;                ///< key=value, what is set otherwise in their scenarios
  std::vector<std::string> with;               ///< overlays, before those
  std::string scenario;  ///< file that tells what is not recorded; empty: what was recorded does
};

/// The scenario of a run of one of its folders: changed as the footage says, with the recording's seed unless
/// that is set. Throws ConfigError.
bench::ReadScenario scenario_of(const Footage& footage, const std::filesystem::path& folder);
/// Likewise, of a recording with that seed, where the footage names a scenario.
bench::ReadScenario scenario_of(const Footage& footage, std::uint64_t seed);
/// Of its first recording.
bench::ReadScenario first_scenario_of(const Footage& footage);

struct Spec {
  std::string name;  ///< the file's stem
  std::vector<Parameter> parameters;
  std::vector<Footage> training, holdout;
  std::vector<Objective> objectives{Objective::pose_nll};  ///< one, or two of which the front is looked for
  Optimiser optimiser = Optimiser::cma_es;
  int trials = 200;      ///< settings tried, polish included
  int polish = 40;       ///< of them by Nelder-Mead from the best
  int population = 10;   ///< of the optimiser
  bool profiles = true;  ///< of the likelihood along each parameter
  int restarts = 2;      ///< at most so many further polishes, from what a profile passed
  std::uint64_t seed = 1;
};

/// Reads a spec; paths in it are relative to its folder. Throws ConfigError ("file:line:column: key: ...") at
/// the first thing that is not as it should be; also FileError where a recording is not there.
Spec read_spec(const std::filesystem::path& file);
Spec read_spec_text(std::string_view text, const std::string& file_name);

/// `value` as the key's reader would find it in a YAML file.
void set(bench::Scenario& scenario, const std::string& key, double value);

}  // namespace sim::tune
