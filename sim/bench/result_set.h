// Results of several seeds and scenarios as they lie in folders, read for being compared.
#pragma once

#include <filesystem>
#include <vector>

#include "sim/bench/scenario.h"
#include "sim/bench/verdict.h"

namespace sim::bench {

/// A scenario's results and the scenario they were made with (that of the first seed).
struct ResultSet {
  ScenarioResults results;
  Scenario scenario;
  std::filesystem::path folder;  ///< holds the seeds' folders
};

/// The exit code that a run with this score ended with, as its scenario's limits have it: 0, 1 or 3.
int exit_code_of(const Scenario& scenario, const SeedScore& score);

/// One result folder. Throws FileError, ConfigError.
SeedScore read_result(const std::filesystem::path& folder);

/// From a result folder, a folder of seed-<n>, or a folder of such folders. In order of names and seeds.
/// Throws FileError when there is no result, or a seed is there twice.
std::vector<ResultSet> read_result_sets(const std::filesystem::path& folder);

}  // namespace sim::bench
