// The recordings of a suite's runs: from the cache, or made first.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/regression/suite.h"

/// The runs of one scenario of a suite.
struct RecordedEntry {
  std::string name;
  std::filesystem::path scenario;
  std::vector<std::string> changes;            ///< key=value
  std::vector<std::filesystem::path> folders;  ///< of each seed, results with a recording
};

/// Has `program` (gaitslam) record what its cache does not have. Throws std::runtime_error where it fails.
std::vector<RecordedEntry> record_suite(const sim::regression::Suite& suite, const std::string& program);
