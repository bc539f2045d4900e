// Scores of several seeds and scenarios: read from result folders, or from a baseline.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "sim/result/score_file.h"
#include "sim/scenario/scenario.h"

namespace sim::regression {

/// The results of one scenario. config: the configuration of its runs, see config_of().
struct ScenarioResults {
  std::string name;
  std::map<std::string, std::string> config;
  std::vector<result::SeedScore> seeds;

  /// Returns the result of that seed, or nullptr.
  const result::SeedScore* find(std::uint64_t seed) const;
};

/// The configuration that determines the runs of a scenario, key to value: the keys that its file and changes
/// set, except limits, name and seed; and the sections that it has.
std::map<std::string, std::string> config_of(const scenario::ReadScenario& read);

/// A scenario's results and the scenario of its first seed.
struct ResultSet {
  ScenarioResults results;
  scenario::Scenario scenario;
  std::filesystem::path folder;  ///< contains the seeds' folders
};

/// Reads one result folder; the exit code follows from the scenario's limits. Throws FileError, ConfigError.
result::SeedScore read_result(const std::filesystem::path& folder);

/// Reads a result folder, a folder of seed-<n> folders, or a folder of such folders, in order of names and
/// seeds. Throws FileError without a result, or with two of the same seed.
std::vector<ResultSet> read_result_sets(const std::filesystem::path& folder);

/// One change of a baseline: its reason, the revision of the program, and the processor.
struct BaselineChange {
  std::string revision, reason, processor;
};

/// The scores of an earlier program, seed by seed, with configurations and hashes of the recordings. Seeds
/// have neither endings nor units.
struct Baseline {
  std::vector<BaselineChange> history;  ///< the latest last
  std::vector<ScenarioResults> scenarios;

  /// Returns the results of that scenario, or nullptr.
  const ScenarioResults* find(const std::string& scenario) const;
};

/// Throws FileError if the file is missing or not a baseline.
Baseline read_baseline(const std::filesystem::path& file);

/// Writes a baseline completely or not at all: one line per metric with the values of its seeds, in decimals
/// that read back to the same bits. Throws FileError.
void write_baseline(const std::filesystem::path& file, const Baseline& baseline);

}  // namespace sim::regression
