// A suite: scenarios that run together, their seeds, and the gates of each. Also scores of several seeds and
// scenarios, read from result folders or a baseline.
#pragma once

#include "sim/result/score_file.h"

namespace sim::regression {

/// A metric to compare, and how much worse it may get: the larger of `percent` of the baseline's median and
/// `absolute`, in the metric's unit. For metrics with an expected value see tolerated_factor().
struct Gate {
  std::string metric;
  double percent = 0, absolute = 0;
  bool operator==(const Gate&) const = default;
};

/// The largest number of gates of a scenario. The p-values are adjusted for this number (Holm 1979), and with
/// 8 seeds even the adjusted smallest p-value, from 2/2^8, must stay below 0.05.
inline constexpr std::size_t kMostGates = 6;

/// Returns the gates of a scenario that does not name any.
const std::vector<Gate>& default_gates();

/// One scenario of a suite. changes: key=value, as on the command line.
struct SuiteEntry {
  fs::path file;
  scenario::Changes changes;
  std::vector<Gate> gates;
  bool expects_missed = false;        ///< `expect: limits_missed`: every seed must miss a limit
  std::vector<scenario::Yaml> set{};  ///< the overrides in `changes` as written in the file
  scenario::Yaml at{};                ///< the value of `gate`, or the entry if that is not given
};

struct Suite {
  std::string name;   ///< the file's stem
  std::string seeds;  ///< as typed by users: "1..3"
  std::vector<SuiteEntry> entries;
  /// `consistent`: NEES and NIS must be those of a filter whose assumed noises are wrong by at most this
  /// factor.
  std::optional<double> consistent{};
};

/// Returns whether a YAML file is a suite: it has the key `scenarios`. Throws ConfigError.
bool is_suite(const fs::path& file);

/// Reads a suite strictly. Scenario files are relative to the suite's folder. Throws ConfigError at the first
/// error, including a suite without scenarios or two scenarios with the same name.
Suite read_suite(const fs::path& file);

/// The results of one scenario. config: the configuration of its runs, see config_of().
struct ScenarioResults {
  std::string name;
  std::map<std::string, std::string> config;
  std::vector<result::SeedScore> seeds;

  /// Returns the result of that seed, or nullptr.
  const result::SeedScore* find(std::uint64_t seed) const;
};

/// Returns the configuration that determines a scenario's runs: the keys set in its file and changes (except
/// limits, name and seed) with their values, and its sections.
std::map<std::string, std::string> config_of(const scenario::ReadScenario& read);

/// A scenario's results, and the scenario as run with its first seed.
struct ResultSet {
  ScenarioResults results;
  scenario::Scenario scenario;
  fs::path folder;  ///< contains the seeds' folders
};

/// Reads the results in a folder at any depth, or in the folder itself: one set for each folder that contains
/// results. Throws FileError if there are none or if a set contains a seed twice.
std::vector<ResultSet> read_result_sets(const fs::path& folder);

/// A change of a baseline: its reason, the program's revision, and the processor.
struct BaselineChange {
  std::string revision, reason, processor;
};

/// The scores of an earlier version of the program, seed by seed, with configurations and hashes of the
/// recordings. These seeds have neither endings nor units.
struct Baseline {
  std::vector<BaselineChange> history;  ///< newest last
  std::vector<ScenarioResults> scenarios;

  /// Returns the results of that scenario, or nullptr.
  const ScenarioResults* find(const std::string& scenario) const;
};

/// Reads a baseline. Throws FileError if the file is missing or not a baseline.
Baseline read_baseline(const fs::path& file);

/// Writes a baseline completely or not at all. Each metric is one line with the values of its seeds, in
/// decimals that read back to the same bits. Throws FileError.
void write_baseline(const fs::path& file, const Baseline& baseline);

}  // namespace sim::regression
