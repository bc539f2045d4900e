// Several seeds of one scenario, each in a process of its own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/scenario/scenario.h"
#include "tools/cli/jobs/run_all.h"

namespace cli {

struct Batch {
  std::vector<std::uint64_t> seeds;
  std::filesystem::path root;  ///< holds the results seed-<n>
  std::filesystem::path models;
  std::optional<std::filesystem::path>
      recordings{};  ///< replay seed-<n> of this folder instead of simulating
  /// Who set which key, for the about.json of the results.
  std::map<std::string, std::string, std::less<>> origin{};
  bool cached = false;  ///< simulate only the walks that the cache does not have
  Backend backend{};
  ShowPart progress{};              ///< absent: a progress line on the terminal
  std::vector<std::string> more{};  ///< arguments of every process
  /// Called when a seed has a new result, but not on Slurm; absent: not called.
  std::function<void(std::uint64_t seed)> on_made{};
};

/// How the process of one seed ended. Where it left no result, there is none: an earlier one was moved.
struct SeedOutcome : Ended {
  std::uint64_t seed = 0;
};

/// Called by the process of a seed, whose scenario file was written by the batch: reads from `set_by` who set
/// which key originally.
void take_origin(sim::scenario::ReadScenario& read, const std::filesystem::path& set_by);

/// Runs all seeds and returns how they ended, in the order of batch.seeds. An earlier result of a seed stays
/// until the new one is whole; where its process leaves none, it is set aside (earlier.h). Throws FileError,
/// before anything is run, where a result would replace what the program did not make.
std::vector<SeedOutcome> run_batch(const sim::scenario::Scenario& scenario, const Batch& batch);

}  // namespace cli
