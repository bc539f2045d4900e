// Results of runs, each made by its own process. Finished ones are kept when an interrupted command is rerun;
// stale ones are moved aside.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/result/score_file.h"
#include "sim/scenario/scenario.h"
#include "tools/cli/jobs/backend.h"
#include "tools/cli/shared/out_folder.h"

namespace cli {

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
  std::vector<std::string> more{};  ///< arguments of every process
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

/// True if this program made the result from the job's scenario, seed, and recording or models.
bool is_finished(const fs::path& result, const ResultJob& job, const std::string& models_hash);

/// Identifies the inputs of a scenario: its YAML and the contents of its estimator's files.
std::string inputs_of(const sim::scenario::Scenario& scenario);

/// Identifies what a command makes: the program, the jobs, and further inputs.
std::string identity_of(const std::vector<ResultJob>& jobs, const std::vector<std::string>& inputs);

/// The names of the results seed-<n> of other seeds in a folder.
std::vector<std::string> results_of_other_seeds(const fs::path& root,
                                                const std::vector<std::uint64_t>& seeds);

/// Moves these folders of `root` into its first folder earlier-<n> that does not exist yet, and reports it on
/// standard output. Throws a FileError that names those that cannot be moved, after the others were.
void set_aside(const fs::path& root, const std::vector<std::string>& names);

/// Reads the origin of each key from `set_by`. For the process of a job.
void take_origin(sim::scenario::ReadScenario& read, const fs::path& set_by);

}  // namespace cli
