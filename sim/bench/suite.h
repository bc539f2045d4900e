// A suite: scenarios that are run together, on which seeds, and what is watched of each.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/bench/verdict.h"

namespace sim::bench {

/// One scenario of a suite. changes: key=value, as on the command line.
struct SuiteEntry {
  std::filesystem::path file;
  Changes changes;
  std::vector<Gate> gates;
};

struct Suite {
  std::string name;   ///< the file's stem
  std::string seeds;  ///< as users type them: "1..3"
  std::vector<SuiteEntry> entries;
};

/// Reads a suite strictly; scenario files are relative to the suite's folder. Throws ConfigError at the first
/// thing that is not as it should be: also at no scenario at all, and at two of one name.
Suite read_suite(const std::filesystem::path& file);

/// What shapes the runs of a scenario, key to value: the keys that its file and changes set, but for limits,
/// name and seed; and the sections that it has.
std::map<std::string, std::string> config_of(const ReadScenario& read);

}  // namespace sim::bench
