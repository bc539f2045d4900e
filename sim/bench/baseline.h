// A baseline: what a program once scored, seed by seed, with what it was asked and what it saw.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/bench/verdict.h"

namespace sim::bench {

/// Why a baseline was made, or made anew, from which revision, on which processor.
struct BaselineChange {
  std::string revision, reason, processor;
};

struct Baseline {
  std::vector<BaselineChange> history;  ///< the latest last
  std::vector<ScenarioResults> scenarios;

  const ScenarioResults* find(const std::string& scenario) const;
};

/// Reads a baseline. Throws FileError when it is not there, when a byte of it is not as it was written, or
/// when it is none.
Baseline read_baseline(const std::filesystem::path& file);

/// Writes it whole or not at all: one line per metric, its seeds' values with the digits that bring the same
/// bits back; the last line holds the hash of all bytes before it. Throws FileError.
void write_baseline(const std::filesystem::path& file, const Baseline& baseline);

/// One hash of a scenario's configuration.
std::string config_hash(const std::map<std::string, std::string>& config);

}  // namespace sim::bench
