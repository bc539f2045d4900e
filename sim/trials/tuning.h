// A whole tuning: search, the test on hold-out recordings, and the files of the result.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/result/job_log.h"
#include "sim/trials/spec.h"
#include "sim/trials/trial.h"

namespace sim::trials {

using result::JobLog, result::JobRecord;

/// Returns the loss of a trial: its objective term. A failed trial loses more than any that succeeded; early
/// failures lose most.
double loss_of(const JobRecord& record, Objective objective);
/// Returns the mean loss over the records.
double mean_loss(const std::vector<const JobRecord*>& records, Objective objective);

/// Called with the part of the search that is done, 0 to 1, and the current step in words.
using ShowProgress = std::function<void(double part, const std::string& at)>;

struct TuningResult {
  /// The 95 % interval of the mean change of the hold-out loss, paired by recording, is below 0, and no
  /// recording fails that the start completes.
  bool accepted = false;
  std::string text;      ///< a summary for the terminal
  std::string judgment;  ///< its last line: the verdict, its interval and its pairs
};

/// Tunes a spec with the folder of every run, and writes to `out`: trials.jsonl (the log of that program,
/// from which it resumes), history.csv, tune.json and, if accepted, best.yaml. Throws FileError.
TuningResult tune(const Spec& spec, const std::filesystem::path& out, const RunTasks& run_tasks,
                  const std::string& program, const ShowProgress& show);

/// Returns the first line of the log.
std::string log_purpose(const std::string& program, const Spec& spec);

}  // namespace sim::trials
