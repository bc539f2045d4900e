// A suite: scenarios that are run together, their seeds, and the gates of each. Scores of several seeds and
// scenarios: read from result folders, or from a baseline.
#pragma once

#include "sim/result/score_file.h"

namespace sim::regression {

/// A metric to compare and its tolerance for the worse: the larger of `percent` of the
/// baseline's median and `absolute`, in the metric's unit. For metrics with an expected value see
/// tolerated_factor().
struct Gate {
  std::string metric;
  double percent = 0, absolute = 0;
  bool operator==(const Gate&) const = default;
};

/// The largest number of gates of a scenario: the p-values are adjusted for their number (Holm 1979), and
/// with 8 seeds the least p-value, 2/2^8, stays below 0.05 after that.
inline constexpr std::size_t kMostGates = 6;

/// Returns the gates of a scenario that names none.
const std::vector<Gate>& default_gates();

/// One scenario of a suite. changes: key=value, as on the command line.
struct SuiteEntry {
  fs::path file;
  scenario::Changes changes;
  std::vector<Gate> gates;
  bool expects_missed = false;        ///< `expect: limits_missed`: every seed is to miss a limit
  std::vector<scenario::Yaml> set{};  ///< the overrides of `changes` as they stand in the file
};

struct Suite {
  std::string name;   ///< the file's stem
  std::string seeds;  ///< as users type them: "1..3"
  std::vector<SuiteEntry> entries;
};

/// Returns whether a YAML file is a suite: it has the key `scenarios`. Throws ConfigError.
bool is_suite(const fs::path& file);

/// Reads a suite strictly; scenario files are relative to the suite's folder. Throws ConfigError at the first
/// error (also without a scenario, or if two have the same name).
Suite read_suite(const fs::path& file);

/// The results of one scenario. config: the configuration of its runs, see config_of().
struct ScenarioResults {
  std::string name;
  std::map<std::string, std::string> config;
  std::vector<result::SeedScore> seeds;

  /// Returns the result of that seed, or nullptr.
  const result::SeedScore* find(std::uint64_t seed) const;
};

/// Returns the configuration that determines a scenario's runs, key to value: the keys set by its file and
/// changes, except limits, name and seed; and its sections.
std::map<std::string, std::string> config_of(const scenario::ReadScenario& read);

/// A scenario's results and the scenario of its first seed.
struct ResultSet {
  ScenarioResults results;
  scenario::Scenario scenario;
  fs::path folder;  ///< contains the seeds' folders
};

/// Reads the results in a folder at any depth, or the folder itself: a set for each folder that contains
/// some. Throws FileError without a result, or if a set has two of the same seed.
std::vector<ResultSet> read_result_sets(const fs::path& folder);

/// One change of a baseline: its reason, the revision of the program, and the processor.
struct BaselineChange {
  std::string revision, reason, processor;
};

/// The scores of an earlier program, seed by seed, with configurations and hashes of the recordings. Seeds
/// have neither endings nor units.
struct Baseline {
  std::vector<BaselineChange> history;  ///< the latest last
  std::vector<ScenarioResults> scenarios;

  /// Returns the results of that scenario, or nullptr.
  const ScenarioResults* find(const std::string& scenario) const;
};

/// Reads a baseline. Throws FileError if the file is missing or not a baseline.
Baseline read_baseline(const fs::path& file);

/// Writes a baseline completely or not at all: one line per metric with the values of its seeds, in decimals
/// that read back to the same bits. Throws FileError.
void write_baseline(const fs::path& file, const Baseline& baseline);

}  // namespace sim::regression
