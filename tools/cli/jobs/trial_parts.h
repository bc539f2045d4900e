// Runs many trials in several processes, here or on a cluster, and collects their records in one log.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/tune/task.h"
#include "tools/cli/jobs/backend.h"

namespace cli {

/// folder: holds parts of the trials and their logs while they run; all nodes of a cluster must see it.
struct PartsPlace {
  std::filesystem::path folder;
  std::string purpose;  ///< first line of the log
  std::filesystem::path models;
  std::string title;  ///< of the progress line
};

/// Runs the tasks and adds their records to the log. Tasks that share a recording should follow each other.
/// Continues with what an earlier call that was killed left in the folder. A task that has no record
/// afterwards could not be run at all; the reason was written to standard error.
void run_parts(const std::vector<sim::tune::Task>& tasks, sim::tune::TrialLog& log, const PartsPlace& place,
               const Backend& backend);

/// Removes the parts that an earlier call left in the folder, and the folder when nothing else is in it.
void remove_parts(const std::filesystem::path& folder);

}  // namespace cli
