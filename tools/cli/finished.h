// Which results are finished, so that an interrupted command goes on with the others.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/scenario/scenario.h"

namespace cli {

/// Whether the folder holds a result that this program made of this scenario and seed.
bool is_finished(const std::filesystem::path& result, sim::scenario::Scenario scenario, std::uint64_t seed);

/// Those of the seeds whose result root/seed-<n> is not finished.
std::vector<std::uint64_t> unfinished(const std::filesystem::path& root,
                                      const sim::scenario::Scenario& scenario,
                                      const std::vector<std::uint64_t>& seeds);

/// Identifies what a command runs: this program, the scenarios, each as YAML, the seeds and the options that
/// matter.
std::string identity_of_runs(const std::vector<std::string>& scenarios,
                             const std::vector<std::uint64_t>& seeds, const std::string& options);

}  // namespace cli
