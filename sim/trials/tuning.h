// A whole tuning: the search, the test on hold-out recordings, and the result files.
#pragma once

#include "sim/trials/trial.h"
#include "sim/trials/values.h"

namespace sim::trials {

/// A recording, and the scenario with which to replay it.
struct SpecRun {
  std::string name;             ///< "tangent_circle/seed-1"
  scenario::ReadScenario read;  ///< with the recording's seed, unless the entry sets another
  std::uint64_t recorded_seed = 0;
  fs::path folder{};  ///< the result folder; empty: it is in the cache
};

/// The loss that a tuning minimizes: see trial.h, or the metric.
enum class Objective { pose_nll, innovation_nll, rmse_m };
/// Returns the objective's name in a spec and in a trial's record.
std::string_view name(Objective objective);

struct Spec {
  std::string name;               ///< the stem of the file's name
  std::vector<Range> parameters;  ///< each with a start
  std::vector<SpecRun> training, holdout;
  Objective objective = Objective::pose_nll;
  int trials = 200;     ///< settings tried by the search
  int population = 10;  ///< size of a generation of CMA-ES
  std::uint64_t seed = 1;
};

/// Reads a spec; its paths are relative to its folder. Throws ConfigError ("file:line:column: key: ...") at
/// the first error. A hold-out walk that is also in the training is such an error.
Spec read_spec(const fs::path& file);

using result::JobLog, result::JobRecord;

/// Returns the loss of a trial: its objective term. A failed trial has a larger loss than any trial that
/// succeeded; early failures have the largest.
double loss_of(const JobRecord& record, Objective objective);
/// Returns the mean loss over the records.
double mean_loss(const std::vector<const JobRecord*>& records, Objective objective);

/// Called with the fraction of the search that is done, 0 to 1, and the current step in words.
using ShowProgress = std::function<void(double part, const std::string& at)>;

struct TuningResult {
  /// The 95 % interval of the mean change of the hold-out loss, paired by recording, is below 0, and
  /// every recording completed with the start is also completed with the best setting.
  bool accepted = false;
  std::string text;      ///< a summary for the terminal
  std::string judgment;  ///< its last line: the verdict with interval and number of pairs
};

/// Tunes a spec, given the folder of every run. Writes to `out`: trials.jsonl (that program's log, from which
/// it can resume), history.csv, tune.json and, if accepted, best.yaml. Throws FileError.
TuningResult tune(const Spec& spec, const fs::path& out, const RunTasks& run_tasks,
                  const std::string& program, const ShowProgress& show);

/// Returns the first line of the log.
std::string log_purpose(const std::string& program, const Spec& spec);

}  // namespace sim::trials
