// Results of several seeds and scenarios, read from their folders to be compared.
#pragma once

#include <filesystem>
#include <vector>

#include "sim/regression/verdict.h"
#include "sim/scenario/scenario.h"

namespace sim::regression {

/// A scenario's results and the scenario they were made with (that of the first seed).
struct ResultSet {
  ScenarioResults results;
  scenario::Scenario scenario;
  std::filesystem::path folder;  ///< holds the seeds' folders
};

/// Reads one result folder; the exit code follows from the scenario's limits. Throws FileError, ConfigError.
result::SeedScore read_result(const std::filesystem::path& folder);

/// Reads a result folder, a folder of seed-<n> folders, or a folder of such folders, in order of names and
/// seeds. Throws FileError if there is no result, or two of the same seed.
std::vector<ResultSet> read_result_sets(const std::filesystem::path& folder);

}  // namespace sim::regression
