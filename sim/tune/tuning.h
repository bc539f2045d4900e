// A tuning from its spec to its answer: search, profiles, the test on hold-out recordings, all left in a
// folder.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "sim/tune/spec.h"
#include "sim/tune/study.h"

namespace sim::tune {

/// How far a tuning is: settings tried of how many (as far as is known), the best objective so far.
struct Standing {
  std::string stage;  ///< "search", "profiles", "polish", "hold-out"
  int tried = 0, of = 0;
  double best = 0;
};

/// What came of it. accepted: on the hold-out recordings the tuned setting is no worse than the start.
struct Answer {
  bool accepted = false;
  std::string text;  ///< for the terminal
};

/// Tunes, and leaves in `out`: trials.jsonl (the log, from the first trial on), then history.csv, tune.json
/// and, if accepted, best.yaml. Begun again with the same spec it goes on from the log, to the same answer
/// bit for bit wherever its trials run. program: its version, in the log's first line. Throws as TrialLog,
/// load and write_durably do.
Answer tune(const Spec& spec, const std::filesystem::path& out, const Where& where,
            const std::string& program, const std::function<void(const Standing&)>& told);

/// The first line of such a log.
std::string log_purpose(const std::string& program);

}  // namespace sim::tune
