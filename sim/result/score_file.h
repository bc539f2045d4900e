// score.json and about.json, as read from a result folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "sim/files/json.h"
#include "sim/scenario/options.h"
#include "sim/scenario/scenario.h"

namespace sim::result {

/// One metric of one seed, as in score.json.
struct SeedMetric {
  std::string name, unit;
  std::optional<double> value;
  std::string reason{};               ///< as in score::Metric
  std::optional<std::string> note{};  ///< as in score::Metric
};

/// A limit on a metric or on an aggregate of it over seeds. If there is no value, the limit is missed. If the
/// scenario has no filter, it is not judged, and `passed` is absent too. reason: why a value over seeds is
/// absent.
struct JudgedLimit {
  scenario::MetricLimit limit;
  std::optional<double> value;
  std::optional<bool> passed;
  std::optional<std::string> reason = {};

  bool missed() const { return passed && !*passed; }
};

/// An interval of lost tracking ("lost"), or of a sensor that contradicts the filter's model ("suspect").
struct ScoredFault {
  std::string kind, cause;
  double from_s = 0;
  std::optional<double> to_s{};  ///< absent: lasts until the end
};

/// Separates a failure's cause from the last lines of the program that failed.
inline constexpr std::string_view kLastLines = "; its last lines: ";

/// The score of one seed.
struct SeedScore {
  std::uint64_t seed = 0;
  scenario::Ending ending =
      scenario::Ending::not_started;  ///< not_started or crashed if its process left no score
  int exit_code = 3;                  ///< exit code of the run
  std::vector<SeedMetric> metrics;
  std::string recording{};   ///< hash of the recording; empty if unknown
  std::string cause{};       ///< cause of the ending; empty if unknown
  std::string last_lines{};  ///< last lines of the estimator's log
  double wall_s = 0;         ///< duration of the run; 0 if unknown
  std::string scenario{}, estimator = "filter";
  std::vector<JudgedLimit> limits{};
  std::vector<ScoredFault> faults{};
  std::optional<bool> repeatable{};  ///< only if answers take simulated time

  /// Returns the value of a metric, or nothing if it has none or is not in the score.
  std::optional<double> value(const std::string& metric) const;
  /// Returns the fraction of the true poses with an estimate, at most the tracked fraction of the time.
  std::optional<double> coverage() const;
};

/// Reads a score.json. Throws FileError, also if a value has the wrong type.
SeedScore read_score(const fs::path& file);

/// Reads the score of a result folder with cause, recording, wall time, and the last lines of the estimator's
/// log, sanitized. Throws FileError.
SeedScore read_result(const fs::path& folder);

/// Returns the score of a run without score.json, from the exit code of its process: not started (2) or
/// crashed.
SeedScore without_score(std::uint64_t seed, int exit_code);

/// about.json. Missing entries are empty or absent.
struct About {
  std::string program, version, revision;
  std::string scenario, estimator;
  std::uint64_t seed = 0;
  std::string cause;  ///< cause of the run's ending
  std::optional<scenario::Ended> walk;
  /// For a replay: why its estimator would steer a different walk.
  std::optional<std::string> counterfactual;
  std::string alignment;        ///< alignment of an external trajectory with the truth
  std::string recording;        ///< hash of the recording's manifest
  std::string models;           ///< hash of the walk's models
  std::string estimator_files;  ///< hash of the files of external programs (controller, estimator)
  std::map<std::string, std::string, std::less<>> set_by;  ///< the origin of each key
};

/// Reads an about.json. Throws FileError "file: key: ..." if it cannot be read or a value has the wrong type.
About read_about(const fs::path& file);

/// Reads the about.json of a result that will be replayed. Throws FileError, also if the walk's ending is
/// missing.
About read_about_of_walk(const fs::path& file);

/// Returns whether the folder is a result, that is, contains a score.json.
bool is_result(const fs::path& folder);

/// Returns the seed in the name of a result, seed-<n> as written by the program (not seed-07).
std::optional<std::uint64_t> seed_of(const fs::path& result);

/// Returns the results in a folder at any depth, or in the folder itself, in the order of names and seeds.
/// Skips recordings, exports, results inside results, hidden folders and symbolic links.
std::vector<fs::path> find_results(const fs::path& folder);

/// Returns the seeds of the results seed-<n> in a folder, in order.
std::vector<std::uint64_t> seeds_in(const fs::path& folder);

/// All inputs of a result besides its seed and, for a replay, the recording.
struct Provenance {
  std::string scenario;         ///< its YAML with seed 0
  std::string revision;         ///< revision of the program
  std::string models;           ///< hash of the models
  std::string estimator_files;  ///< hash of external programs' files; empty without any
  bool operator==(const Provenance&) const = default;
};
/// revision: the program's revision. models: hash of the models. Throws FileError.
Provenance provenance_of(scenario::Scenario scenario, const std::string& revision, const std::string& models);
/// Throws FileError or ConfigError if the result is incomplete.
Provenance provenance_of(const fs::path& result);

}  // namespace sim::result
