// Recordings, results of runs and trials, each made by a process. Finished ones are kept when an interrupted
// command is rerun; stale results are moved aside.
#pragma once

#include "sim/recording/cache.h"
#include "sim/result/score_file.h"
#include "tools/cli/jobs/jobs.h"
#include "tools/cli/shared/out_folder.h"

namespace cli {

/// Recordings of the cache, made by simulating the walk if they are missing.
class Recordings {
 public:
  /// models: the folder of the models of robot and rooms. Throws FileError, std::invalid_argument.
  explicit Recordings(fs::path models);

  /// Returns the name of the scenario's recording in the cache.
  std::string key(const scenario::Scenario& scenario) const;

  /// Returns the recording from the cache after checking every byte, or nullopt if it is missing.
  std::optional<recording::CachedRecording> find(const scenario::Scenario& scenario) const;

  /// Returns the recording from the cache; this process records a missing one. Throws what a run throws.
  recording::CachedRecording get(const scenario::ReadScenario& read, const result::Progress& progress) const;

  struct Made {
    fs::path folder;      ///< in the cache; empty if it could not be made
    bool is_new = false;  ///< made by this call
    JobRecord record{};   ///< of its process
  };
  /// Makes the missing recordings and returns all in the order of the scenarios.
  std::vector<Made> make(const std::vector<scenario::ReadScenario>& scenarios, Backend backend) const;

  const recording::CachePlace& place() const { return cache_.place(); }

 private:
  fs::path models_;
  std::string models_hash_, program_;
  recording::Cache cache_;
};

/// A result folder to make.
struct ResultJob {
  scenario::ReadScenario read;  ///< with its seed
  std::string folder;           ///< of results seed-<n>, within the folder of the command; may be empty
  std::optional<fs::path> recording{};  ///< the result folder to replay; absent: the walk is simulated
  double cost = 1;                      ///< relative to the other jobs
  /// The words of its command line up to --out; empty: a run, or a replay of the recording.
  std::vector<std::string> command{};

  std::uint64_t seed() const { return read.scenario.seed; }
  /// Returns the path of the result within the folder of the command: <folder>/seed-<n>.
  std::string result() const;
};

/// Returns the same job for each of the seeds.
std::vector<ResultJob> jobs_of_seeds(const ResultJob& job, const std::vector<std::uint64_t>& seeds);
/// Returns a use of the folder that the same jobs, models and program resume after an interruption.
OutUse resumable(const std::vector<ResultJob>& jobs, const fs::path& models = {}, bool cached = false);

struct ResultOptions {
  fs::path models;
  std::string title;          ///< of the progress line
  Backend backend{};          ///< its spool may be empty
  bool cached = false;        ///< simulate only the walks that the cache does not have
  bool counts_older = false;  ///< keep finished results of older commands
  bool keeps_other_seeds = false;
  std::vector<std::uint64_t> kept_seeds{};  ///< other seeds that are not set aside
  bool must_start = false;                  ///< a process that rejects its input is a UsageError
};

/// Makes the results that are not finished, each replacing an earlier one when it is whole, and returns the
/// records in the order of the jobs, empty for those finished before. Prints complaints of failed processes
/// and moves stale results to earlier-<n>; throws FileError if a result would replace a user's files.
std::vector<JobRecord> make_results(const std::vector<ResultJob>& jobs, const OutFolder& out,
                                    const ResultOptions& options);

/// Returns the score of each job's result, or "crashed" if it has none.
std::vector<result::SeedScore> read_scores(const std::vector<ResultJob>& jobs,
                                           const std::vector<JobRecord>& ended, const fs::path& out);

/// Returns text that identifies a scenario's inputs: its YAML and the contents of its estimator's files.
std::string inputs_of(const scenario::Scenario& scenario);

/// Returns the seeds of other results seed-<n> in a folder that this program made from the scenario of the
/// jobs, which have one folder.
std::vector<std::uint64_t> finished_beside(const std::vector<ResultJob>& jobs, const fs::path& root,
                                           const fs::path& models);

}  // namespace cli
