// Results in the archive that the evaluation program evo reads: `evo_res a.zip b.zip -p --save_table t.csv`.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace sim::stream {

/// error, seconds, distances belong together, one of each per pose or span. matrix: the similarity that
/// aligned the estimate.
struct EvoResult {
  std::string title, reference, estimate, label;  ///< label: of the error, with its unit: "APE (m)"
  std::map<std::string, double> statistics;       ///< rmse, mean, median, std, min, max, sse
  std::vector<double> error, timestamps, seconds_from_start, distances_from_start, distances;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
};

/// A ZIP archive of info.json, stats.json and NumPy arrays, whole or not at all. Throws FileError.
void write_evo_zip(const std::filesystem::path& file, const EvoResult& result);

}  // namespace sim::stream
