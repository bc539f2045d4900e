// Recordings and results of runs, each made by its own process. Existing ones are kept, so that a rerun
// resumes an interrupted command.
#pragma once

#include "sim/recording/cache.h"
#include "sim/result/score_file.h"
#include "tools/cli/jobs/jobs.h"
#include "tools/cli/shared/out_folder.h"

namespace cli {

/// Recordings in the cache; missing ones are made by simulating the walk.
class Recordings {
 public:
  /// models: the folder with the models of robots and rooms. Throws FileError, std::invalid_argument.
  explicit Recordings(fs::path models);

  /// Returns the name of the scenario's recording in the cache.
  std::string key(const scenario::Scenario& scenario) const;

  /// Returns the recording from the cache after checking every byte, or nullopt if it is missing.
  std::optional<recording::CachedRecording> find(const scenario::Scenario& scenario) const;

  /// Returns the recording from the cache; if it is missing, this process makes it. Throws whatever a run
  /// throws.
  recording::CachedRecording get(const scenario::ReadScenario& read, const result::Progress& progress) const;

  struct Made {
    fs::path folder;      ///< in the cache; empty if it could not be made
    bool is_new = false;  ///< made by this call
    JobRecord record{};   ///< from its process
  };
  /// Makes the missing recordings and returns all recordings in the order of the scenarios.
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
  std::string folder;           ///< contains results seed-<n>; relative to the command's folder; may be empty
  std::optional<fs::path> recording{};  ///< the result folder to replay; absent: the walk is simulated
  double cost = 1;                      ///< relative to the other jobs
  /// Its command line up to --out; empty: a run, or a replay of the recording.
  std::vector<std::string> command{};
  fs::path
      program{};  ///< another build of this program, whose results are kept if they exist; empty: this one

  std::uint64_t seed() const { return read.scenario.seed; }
  /// Returns the path of the result relative to the command's folder: <folder>/seed-<n>.
  std::string result() const;
};

/// Returns a copy of the job for each seed.
std::vector<ResultJob> jobs_of_seeds(const ResultJob& job, const std::vector<std::uint64_t>& seeds);

struct ResultOptions {
  fs::path models;
  std::string title;        ///< title of the progress line
  Backend backend{};        ///< its spool may be empty
  bool cached = false;      ///< simulate only the walks that are not in the cache
  bool force = false;       ///< replace results that differ or need not be the same when made again
  bool must_start = false;  ///< throws UsageError if a process rejects its input
};

/// How a job ended.
struct ResultEnd {
  bool finished = false;  ///< its folder contains its result
  int exit_code = 0;      ///< exit code of its process, if it was run
  std::string complaint{};
};

/// Makes the results that do not exist yet and returns the outcomes in the order of the jobs. Prints errors
/// of failed processes. Throws UsageError if a result of different settings exists and must not be replaced.
std::vector<ResultEnd> make_results(const std::vector<ResultJob>& jobs, const OutFolder& out,
                                    const ResultOptions& options);

/// Returns the score of each job's result, or "crashed" if it has none.
std::vector<result::SeedScore> read_scores(const std::vector<ResultJob>& jobs,
                                           const std::vector<ResultEnd>& ends, const fs::path& out);

/// Returns text that identifies a scenario's inputs: its YAML and the contents of its programs' files.
std::string inputs_of(const scenario::Scenario& scenario);

/// Returns the seeds of the results seed-<n> in a folder that have the job's settings. Throws UsageError if
/// any have different settings, unless `force`.
std::vector<std::uint64_t> seeds_beside(const ResultJob& job, const fs::path& root, const fs::path& models,
                                        bool force);

}  // namespace cli
