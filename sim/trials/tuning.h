// A whole tuning: search, the test on hold-out recordings, and the files of the result.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "sim/trials/spec.h"
#include "sim/trials/study.h"

namespace sim::trials {

/// The progress of a tuning: settings tried, of how many (0: not known), and the least loss so far.
struct Progress {
  std::string stage;  ///< "search" or "hold-out"
  int tried = 0, of = 0;
  double best = 0;
};

/// accepted: the tuned setting is at least as good as the start on the hold-out recordings.
struct TuningResult {
  bool accepted = false;
  std::string text;  ///< a summary for the terminal
};

/// Tunes, and writes to `out`: trials.jsonl (the log), then history.csv, tune.json and, if accepted,
/// best.yaml. Resumes from the log of the same spec; the result has the same bits for any `execution`.
/// program: identifies it in the log. Throws FileError.
TuningResult tune(const Spec& spec, const std::filesystem::path& out, const Execution& execution,
                  const std::string& program, const std::function<void(const Progress&)>& on_progress);

/// The first line of the log.
std::string log_purpose(const std::string& program, const Spec& spec);

}  // namespace sim::trials
