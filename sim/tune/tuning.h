// A tuning from its spec to its result: search, profiles, the test on hold-out recordings, all written to a
// folder.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "sim/tune/spec.h"
#include "sim/tune/study.h"

namespace sim::tune {

/// How far a tuning is: settings tried, of how many (0: not known), and the least loss so far.
struct Progress {
  std::string stage;  ///< "search", "profiles", "polish" or "hold-out"
  int tried = 0, of = 0;
  double best = 0;
};

/// accepted: on the hold-out recordings the tuned setting is no worse than the start.
struct TuningResult {
  bool accepted = false;
  std::string text;  ///< a summary for the terminal
};

/// Tunes, and writes to `out`: trials.jsonl (the log, from the first trial on), then history.csv, tune.json
/// and, if accepted, best.yaml. Started again with the same spec it continues from the log; the result is the
/// same bit for bit, whatever `execution`. program: its version, for the first line of the log. Throws as
/// TrialLog, load and write_atomically do.
TuningResult tune(const Spec& spec, const std::filesystem::path& out, const Execution& execution,
                  const std::string& program, const std::function<void(const Progress&)>& on_progress);

/// The first line of such a log.
std::string log_purpose(const std::string& program);

}  // namespace sim::tune
