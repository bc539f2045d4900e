// The specification of a tuning: parameters, objective and recordings, from one YAML file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/scenario/scenario.h"
#include "sim/trials/values.h"

namespace sim::trials {

/// Recordings that are replayed with the same changes of their scenario: one result folder, seeds of a folder
/// with seed-<n>, or seeds of a scenario with recordings in the cache.
struct RecordingSet {
  std::vector<std::filesystem::path> folders;  ///< result folders; those of the cache are added when found
  std::vector<std::uint64_t> seeds;            ///< of recordings in the cache; empty for named folders
  std::vector<std::string> set;                ///< key=value changes of the scenario, applied last
  std::vector<std::string> with;               ///< overlay files, applied before `set`
  std::string scenario;  ///< scenario file to replay with; empty: the one that was recorded
};

/// The scenario to replay a result folder of the set with: changed by the set, with the seed of the
/// recording unless the set changes it. Throws ConfigError.
scenario::ReadScenario scenario_of(const RecordingSet& set, const std::filesystem::path& folder);
/// The scenario to replay the recording of that seed with; the set must name a scenario file.
scenario::ReadScenario scenario_of(const RecordingSet& set, std::uint64_t seed);
/// The scenario of the first recording of the set.
scenario::ReadScenario first_scenario_of(const RecordingSet& set);

/// The loss that a tuning minimizes, see Terms.
enum class Objective { pose_nll, innovation_nll, rmse_m };
/// Its name in a spec and in a trial's record.
std::string_view name(Objective objective);

struct Spec {
  std::string name;               ///< the stem of the file's name
  std::vector<Range> parameters;  ///< each with a start
  std::vector<RecordingSet> training, holdout;
  Objective objective = Objective::pose_nll;
  int trials = 200;     ///< settings tried by the search
  int population = 10;  ///< of a generation of CMA-ES
  std::uint64_t seed = 1;
  std::string warning = {};  ///< about a hold-out that is not fully independent; empty if it is
};

/// Reads a spec; its paths are relative to its folder. Throws ConfigError ("file:line:column: key: ...") at
/// the first fault, among them a hold-out with a walk of the training; FileError if a recording is missing.
Spec read_spec(const std::filesystem::path& file);

}  // namespace sim::trials
