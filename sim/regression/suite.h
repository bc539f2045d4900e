// A suite: scenarios that are run together, their seeds, and the gates of each.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/regression/verdict.h"
#include "sim/scenario/yaml.h"

namespace sim::regression {

/// One scenario of a suite. changes: key=value, as on the command line.
struct SuiteEntry {
  std::filesystem::path file;
  scenario::Changes changes;
  std::vector<Gate> gates;
  std::vector<scenario::Yaml> set{};  ///< the overrides of `changes` as they stand in the file
};

struct Suite {
  std::string name;   ///< the file's stem
  std::string seeds;  ///< as users type them: "1..3"
  std::vector<SuiteEntry> entries;
};

/// Returns whether a YAML file is a suite: it has the key `scenarios`. Throws ConfigError.
bool is_suite(const std::filesystem::path& file);

/// Reads a suite strictly; scenario files are relative to the suite's folder. Throws ConfigError at the first
/// error (also without a scenario, or if two have the same name).
Suite read_suite(const std::filesystem::path& file);

}  // namespace sim::regression
