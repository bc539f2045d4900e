// Runs trials in several processes, here or on a cluster, and collects their records in one log.
#pragma once

#include <filesystem>
#include <string>

#include "sim/trials/trial.h"
#include "tools/cli/jobs/backend.h"

namespace cli {

/// folder: contains the parts of the trials and their logs while they run; all nodes of a cluster must see
/// it.
struct TrialsPlace {
  std::filesystem::path folder;
  std::string purpose;  ///< first line of the log
  std::filesystem::path models;
  std::string title;  ///< of the progress line
};

/// Returns a function that runs tasks in processes. Tasks of the same recording should follow each other. It
/// resumes what a killed call left in the folder. A task without a record afterwards could not be run; the
/// reason is on standard error.
sim::trials::RunTasks in_processes(const TrialsPlace& place, const Backend& backend);

/// Removes the parts that an earlier call left in the folder, and the folder if nothing else is in it.
void remove_parts(const std::filesystem::path& folder);

}  // namespace cli
