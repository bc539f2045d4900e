// The recordings that a tuning learns from or is tested on, and the scenario that each is replayed with.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/scenario/scenario.h"
#include "sim/scenario/yaml.h"

namespace sim::tune {

/// Recordings that are replayed with the same changes of their scenario: one result folder, seeds of a folder
/// that holds seed-<n>, or seeds of a scenario whose recordings are in the cache.
struct RecordingSet {
  std::vector<std::filesystem::path> folders;  ///< result folders; those of the cache are added when found
  std::vector<std::uint64_t> seeds;            ///< of recordings in the cache; empty for named folders
  std::vector<std::string> set;                ///< key=value changes of the scenario, applied last
  std::vector<std::string> with;               ///< overlay files, applied before `set`
  std::string scenario;  ///< scenario file to replay with; empty: the one that was recorded
};

/// The scenario to replay a result folder of the set with: changed as the set says, with the seed of the
/// recording unless the set changes that. Throws ConfigError.
scenario::ReadScenario scenario_of(const RecordingSet& set, const std::filesystem::path& folder);
/// The scenario to replay the recording with that seed with; the set must name a scenario file.
scenario::ReadScenario scenario_of(const RecordingSet& set, std::uint64_t seed);
/// The scenario of the first recording of the set.
scenario::ReadScenario first_scenario_of(const RecordingSet& set);

/// Reads a list of {recordings: FOLDER, seeds: 1..5, scenario: FILE, set: [key=value], with: [FILE]}; an
/// entry without `recordings` means those of its scenario in the cache. Relative paths start at `folder`.
/// Throws ConfigError at the node that is wrong.
std::vector<RecordingSet> read_recording_sets(const scenario::Yaml& node, const std::string& key,
                                              const std::filesystem::path& folder);

}  // namespace sim::tune
