// The results in a tree of folders: finding them, their provenance, and the summary of a folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/result/score_file.h"
#include "sim/scenario/scenario.h"

namespace sim::result {

/// Returns whether the folder is a result: it has a score.json.
bool is_result(const std::filesystem::path& folder);

/// Returns the seed in the name of a result, seed-<n> as the program writes it (not seed-07).
std::optional<std::uint64_t> seed_of(const std::filesystem::path& result);

/// Treatment of results inside results, such as replays.
enum class Nested { skip, include };

/// Returns the results in a folder at any depth, or the folder itself, in the order of names and seeds. Skips
/// recordings, exports, hidden folders, symbolic links, and earlier-<n>, which replaced results were moved
/// to.
std::vector<std::filesystem::path> find_results(const std::filesystem::path& folder,
                                                Nested nested = Nested::skip);

/// Returns the seeds of the results seed-<n> in a folder, in order.
std::vector<std::uint64_t> seeds_in(const std::filesystem::path& folder);

/// All inputs of a result besides its seed and the recording of a replay.
struct Provenance {
  std::string scenario;         ///< its YAML with seed 0
  std::string revision;         ///< of the program
  std::string models;           ///< their hash
  std::string estimator_files;  ///< their hash; empty of a built-in estimator
  bool operator==(const Provenance&) const = default;
};
Provenance provenance_of(scenario::Scenario scenario, const std::string& revision, const std::string& models);
/// Throws FileError, ConfigError if the result is incomplete.
Provenance provenance_of(const std::filesystem::path& result);

/// Makes the summary.json beside a new result seed-<n> that of all seeds, if there is one and no other
/// process writes it. If these seeds are of different provenance, sets it aside and returns the folder with
/// it.
std::optional<std::filesystem::path> renew_summary(const std::filesystem::path& result);

}  // namespace sim::result
