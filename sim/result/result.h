// The result folder of a run or a replay: trajectories, map, frames, score; written completely or not at all.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "sim/files/atomic_file.h"
#include "sim/result/run_record.h"
#include "sim/result/timing.h"

namespace sim::result {

/// Called as simulated time advances, with the completed fraction (0 to 1).
using Progress = std::function<void(double)>;

/// The folder of a result, and the versions that it states.
struct ResultPlace {
  std::filesystem::path folder;
  files::Existing existing = files::Existing::reject;
  std::filesystem::path models;                  ///< for a live run
  std::string version, revision;                 ///< of the program
  std::map<std::string, std::string> libraries;  ///< name and version
  std::string models_hash{};                     ///< of the models of the walk; empty: unknown
};

/// The ending of a run and its exit code, see limits.h.
struct Outcome : scenario::Ended {
  int exit_code = 0;
};

/// Scores the run and writes all files of the result but recording/ into `folder`. Throws FileError.
Outcome write_result(const std::filesystem::path& folder, const RunRecord& record, const ResultPlace& place,
                     const Timing& timing, double simulated_s);

/// Writes the tracked frames and the map: frames.csv, map.csv, landmarks.csv, map_over_time.csv, searches.csv
/// and, for landmarks that start as lines, depths.csv (README.md describes them). Throws FileError.
void write_tracked(const std::filesystem::path& folder, const tracking::Tracked& tracked);

}  // namespace sim::result
