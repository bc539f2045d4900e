// Recordings and results of runs, each made by its own process. Finished ones are kept when an interrupted
// command is rerun; stale results are moved aside.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/recording/cache.h"
#include "sim/result/score_file.h"
#include "sim/scenario/scenario.h"
#include "tools/cli/jobs/backend.h"
#include "tools/cli/shared/out_folder.h"

namespace cli {

/// Recordings of the cache, made by simulating the walk if they are missing.
class Recordings {
 public:
  /// models: the folder of the models of robot and rooms. Throws FileError, std::invalid_argument.
  explicit Recordings(fs::path models);

  /// The name of the scenario's recording in the cache.
  std::string key(const sim::scenario::Scenario& scenario) const;

  /// Returns the recording from the cache after checking every byte, or nullopt if it is missing.
  std::optional<sim::recording::CachedRecording> find(const sim::scenario::Scenario& scenario) const;

  /// Returns the recording from the cache; this process records it if it is missing. Throws what a run
  /// throws.
  sim::recording::CachedRecording get(const sim::scenario::ReadScenario& read,
                                      const sim::result::Progress& progress) const;

  struct Made {
    fs::path folder;      ///< in the cache; empty if it could not be made
    bool is_new = false;  ///< made by this call
    Ended ended{};        ///< of its process
  };
  /// Makes the recordings that are missing.
  std::vector<Made> make(const std::vector<sim::scenario::ReadScenario>& scenarios,
                         const Backend& backend) const;

  const sim::recording::CachePlace& place() const { return cache_.place(); }

 private:
  fs::path models_;
  std::string models_hash_, program_;
  sim::recording::Cache cache_;
};

/// A result folder to make.
struct ResultJob {
  sim::scenario::ReadScenario read;  ///< with its seed
  std::string folder;                ///< of results seed-<n>, within the folder of the command; may be empty
  std::optional<fs::path> recording{};  ///< the result folder to replay; absent: the walk is simulated
  double cost = 1;                      ///< relative to the other jobs
  /// The words of its command line up to --out; empty: a run, or a replay of the recording.
  std::vector<std::string> command{};

  std::uint64_t seed() const { return read.scenario.seed; }
  /// The path of the result within the folder of the command: <folder>/seed-<n>.
  std::string result() const;
};

/// The same job for each of the seeds.
std::vector<ResultJob> jobs_of_seeds(const ResultJob& job, const std::vector<std::uint64_t>& seeds);
std::vector<std::string> results_of(const std::vector<ResultJob>& jobs);

struct ResultOptions {
  fs::path models;
  std::string title;          ///< of the progress line
  Backend backend{};          ///< its spool may be empty
  bool cached = false;        ///< simulate only the walks that the cache does not have
  bool counts_older = false;  ///< keep finished results of older commands
  bool keeps_other_seeds = false;
};

/// Makes the results that are not finished and returns how their processes ended, in the order of the jobs
/// (exit code 0 and no complaint if finished before). An earlier result stays until the new one is whole; if
/// none is made, it is moved to earlier-<n>, as are results of other seeds. Throws FileError if a result
/// would replace something that the program did not make.
std::vector<Ended> make_results(const std::vector<ResultJob>& jobs, const OutFolder& out,
                                const ResultOptions& options);

/// The score of each job's result, or "crashed" if it has none.
std::vector<sim::result::SeedScore> read_scores(const std::vector<ResultJob>& jobs,
                                                const std::vector<Ended>& ended, const fs::path& out);

/// Prints what failed processes wrote to standard error, once for all seeds with the same complaint.
void print_complaints(const std::vector<ResultJob>& jobs, const std::vector<Ended>& ended);

/// Identifies the inputs of a scenario: its YAML and the contents of its estimator's files.
std::string inputs_of(const sim::scenario::Scenario& scenario);

/// Identifies what a command makes: the program, the jobs, and further inputs.
std::string identity_of(const std::vector<ResultJob>& jobs, const std::vector<std::string>& inputs);

/// The names of the results seed-<n> of other seeds in a folder.
std::vector<std::string> results_of_other_seeds(const fs::path& root,
                                                const std::vector<std::uint64_t>& seeds);

/// Moves these folders of `root` into its first folder earlier-<n> that does not exist yet, and reports it on
/// standard output.
void set_aside(const fs::path& root, const std::vector<std::string>& names);

}  // namespace cli
