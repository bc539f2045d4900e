// Many trials in several processes, here or on a cluster, their records in one log.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/tune/task.h"
#include "tools/cli/backend.h"

namespace cli {

/// Where parts of the trials and their logs lie while they run (all nodes see it), and what they are called.
struct PartsPlace {
  std::filesystem::path folder;
  std::string purpose;  ///< of the log
  std::filesystem::path models;
  std::string title;
};

/// Runs the tasks and adds their records to the log. Tasks that share a recording should follow each other.
/// What an earlier call that was killed has left in the folder is taken up. A task without a record
/// afterwards could not be tried at all; why was written to stderr.
void run_parts(const std::vector<sim::tune::Task>& tasks, sim::tune::TrialLog& log, const PartsPlace& place,
               const Backend& backend);

}  // namespace cli
