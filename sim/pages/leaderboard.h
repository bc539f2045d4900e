// The estimators of a tree of results in one table: a row for each set of results, grouped by scenario.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace sim::pages {

/// The results of one folder that are of the same scenario and estimator: its seeds.
struct LeaderboardRow {
  std::string scenario, estimator;
  std::filesystem::path folder;  ///< of the results
  std::size_t runs = 0, completed = 0;
  std::map<std::string, std::optional<double>> medians;  ///< by metric, over the runs that have it
  std::optional<double> cpu_ms;                          ///< median over the runs, of a frame's mean
};

/// The metrics that are shown unless others are asked for; the first one orders.
std::vector<std::string> leaderboard_metrics();

/// All results below the folders, each once, without recordings and earlier seeds. Orders the rows of a
/// scenario by completed runs, then by the median of the first metric; never compares scenarios. Throws
/// FileError if a result cannot be read or a folder contains none.
std::vector<LeaderboardRow> leaderboard(const std::vector<std::filesystem::path>& folders,
                                        const std::vector<std::string>& metrics);

std::string leaderboard_table(const std::vector<LeaderboardRow>& rows,
                              const std::vector<std::string>& metrics);
std::string leaderboard_csv(const std::vector<LeaderboardRow>& rows, const std::vector<std::string>& metrics);
/// A page that needs no other file.
std::string leaderboard_page(const std::vector<LeaderboardRow>& rows,
                             const std::vector<std::string>& metrics);

}  // namespace sim::pages
