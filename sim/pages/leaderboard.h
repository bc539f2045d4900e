// The estimators of a tree of results in one table: a row for each set of results, grouped by scenario.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sim::pages {

/// The results of one folder that are of the same scenario, estimator and alignment: its seeds.
struct LeaderboardRow {
  std::string scenario, estimator;
  std::string alignment;         ///< of the estimate with the truth before it was scored; "none" without
  std::filesystem::path folder;  ///< of the results
  std::size_t runs = 0, completed = 0;
  std::set<std::uint64_t> seeds;
  /// The mean over all runs of the share of true poses with an estimate; 0 of an incomplete run.
  double coverage = 0;
  std::map<std::string, std::vector<double>> values;  ///< by column, of the runs that have one
  std::vector<std::string> settings;  ///< "key=value" of each key but seed; empty if they cannot be read

  /// Over the runs that have a value; empty if none has.
  std::optional<double> median(const std::string& column) const;
};

struct Leaderboard {
  std::vector<std::string> metrics;  ///< the first one orders
  std::vector<LeaderboardRow> rows;
  std::vector<std::string> left_out;  ///< results that cannot be read, and why
};

/// The metrics that are shown unless others are asked for.
std::vector<std::string> leaderboard_metrics();

/// All results below the folders, each once, without recordings and earlier seeds. Orders the rows of a
/// scenario by coverage in whole percent, then by the median of the first metric; never compares scenarios.
/// Throws FileError if a folder contains no result that can be read.
Leaderboard leaderboard(const std::vector<std::filesystem::path>& folders,
                        const std::vector<std::string>& metrics);

std::string leaderboard_table(const Leaderboard& board);
std::string leaderboard_csv(const Leaderboard& board);
/// A page that needs no other file.
std::string leaderboard_page(const Leaderboard& board);

}  // namespace sim::pages
