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

/// accepted: the tuned setting is at least as good as the start on the hold-out recordings.
struct TuningResult {
  bool accepted = false;
  std::string text;  ///< a summary for the terminal
};

/// Tunes, and writes to `out`: trials.jsonl (the log), then history.csv, tune.json and, if accepted,
/// best.yaml. Every run of the spec needs its folder. Resumes from the log of the same spec; the result has
/// the same bits however run_tasks divides the work. If its estimate steers a walk, a task names no
/// recording: each setting is simulated. program: identifies it in the log. Throws FileError.
TuningResult tune(const Spec& spec, const std::filesystem::path& out, const RunTasks& run_tasks,
                  const std::string& program, const ShowProgress& show);

/// Returns the first line of the log.
std::string log_purpose(const std::string& program, const Spec& spec);

}  // namespace sim::trials
