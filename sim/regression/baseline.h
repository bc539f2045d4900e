// A baseline: the scores of an earlier program, seed by seed, with configurations and hashes of the
// recordings.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/regression/verdict.h"

namespace sim::regression {

/// One change of a baseline: its reason, the revision of the program, and the processor.
struct BaselineChange {
  std::string revision, reason, processor;
};

struct Baseline {
  std::vector<BaselineChange> history;  ///< the latest last
  std::vector<ScenarioResults> scenarios;

  const ScenarioResults* find(const std::string& scenario) const;
};

/// Reads a baseline. Throws FileError if the file is missing, is no baseline, or was changed by other means
/// than write_baseline.
Baseline read_baseline(const std::filesystem::path& file);

/// Writes a baseline completely or not at all: one line per metric with the values of its seeds, in decimals
/// that read back to the same bits; the last line is the hash of all bytes before it. Throws FileError.
void write_baseline(const std::filesystem::path& file, const Baseline& baseline);

/// A hash of a scenario's configuration.
std::string config_hash(const std::map<std::string, std::string>& config);

}  // namespace sim::regression
