// Which results are finished, so that an interrupted command goes on with the others.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/scenario/scenario.h"
#include "tools/cli/out_folder.h"

namespace cli {

/// Whether the folder holds a result that this program made of this scenario and seed.
bool is_finished(const std::filesystem::path& result, sim::scenario::Scenario scenario, std::uint64_t seed);

/// Those of the seeds whose result <within>seed-<n> in the folder the interrupted command has not finished.
std::vector<std::uint64_t> unfinished(const OutFolder& out, const std::string& within,
                                      const sim::scenario::Scenario& scenario,
                                      const std::vector<std::uint64_t>& seeds);

/// Identifies the inputs of a scenario: as YAML, with the contents of its estimator's files.
std::string inputs_of(const sim::scenario::Scenario& scenario);

/// Identifies what a command runs: this program, the scenarios, the seeds and the options that matter.
std::string identity_of_runs(const std::vector<std::string>& scenarios,
                             const std::vector<std::uint64_t>& seeds, const std::string& options);

}  // namespace cli
