// Several seeds of one scenario, each in a process of its own: one that crashes takes no other with it.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/bench/scenario.h"

namespace cli {

struct Batch {
  std::vector<std::uint64_t> seeds;
  int jobs = 1;                ///< processes at a time
  std::filesystem::path root;  ///< seed-<n> goes below
  std::filesystem::path models;
  std::optional<std::filesystem::path> recordings{};  ///< replay seed-<n> of this folder instead of walking
  std::map<std::string, std::string, std::less<>>
      origin{};                            ///< who set which key, for the results' about.json
  std::function<void(double)> progress{};  ///< told the part done; without, a line on the terminal is
};

/// How one seed's process ended.
struct SeedOutcome {
  std::uint64_t seed = 0;
  int exit_code = 0;
  std::string complaint;  ///< what it wrote to stderr, or the signal that killed it
};

/// Called by a seed's process: takes over what the batch knows of who set which key, for the scenario that a
/// seed's process reads is one that the batch wrote.
void take_origin(sim::bench::ReadScenario& read, const std::filesystem::path& set_by);

/// Called by a seed's process: it does not outlive the batch, not even one that has ended by now.
void die_with(pid_t batch);

/// Runs all seeds; in the order of batch.seeds whatever the order in which they end.
std::vector<SeedOutcome> run_batch(const sim::bench::Scenario& scenario, const Batch& batch);

}  // namespace cli
