// Several seeds of one scenario, each in a process of its own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/bench/scenario.h"
#include "tools/cli/backend.h"

namespace cli {

struct Batch {
  std::vector<std::uint64_t> seeds;
  std::filesystem::path root;  ///< seed-<n> goes below
  std::filesystem::path models;
  std::optional<std::filesystem::path> recordings{};  ///< replay seed-<n> of this folder instead of walking
  std::map<std::string, std::string, std::less<>>
      origin{};         ///< who set which key, for the results' about.json
  bool cached = false;  ///< walk only what the cache does not have
  Backend backend{};
  ShowPart progress{};  ///< without, a line on the terminal
};

/// How one seed's process ended.
struct SeedOutcome : Ended {
  std::uint64_t seed = 0;
};

/// Called by a seed's process: takes over what the batch knows of who set which key, for the scenario that a
/// seed's process reads is one that the batch wrote.
void take_origin(sim::bench::ReadScenario& read, const std::filesystem::path& set_by);

/// Runs all seeds; in the order of batch.seeds whatever the order in which they end.
std::vector<SeedOutcome> run_batch(const sim::bench::Scenario& scenario, const Batch& batch);

}  // namespace cli
