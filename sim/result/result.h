// The result folder of a run or a replay: trajectories, map, frames, score; complete or not there at all.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "sim/files/atomic_file.h"
#include "sim/result/run_record.h"
#include "sim/result/timing.h"

namespace sim::result {

/// Called as simulated time advances, with the fraction done (0 to 1).
using Progress = std::function<void(double)>;

/// Where a result goes, and the versions that it names.
struct ResultPlace {
  std::filesystem::path folder;
  files::Existing existing = files::Existing::reject;
  std::filesystem::path models;                  ///< for a live run
  std::string version, revision;                 ///< of the program
  std::map<std::string, std::string> libraries;  ///< name and version
  std::string models_hash{};  ///< of the models that the walk was simulated with; empty: unknown
};

/// How a run ended, and the exit code that follows, see limits.h.
struct Outcome : scenario::Ended {
  int exit_code = 0;
};

/// Scores the run and writes all files of the result but recording/ into `folder`. Throws FileError.
Outcome write_result(const std::filesystem::path& folder, const RunRecord& record, const ResultPlace& place,
                     const Timing& timing, double simulated_s);

}  // namespace sim::result
