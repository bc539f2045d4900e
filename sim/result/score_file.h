// score.json: the metrics of one run, the times in which tracking was lost, and the limits judged.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/files/json.h"
#include "sim/result/limits.h"
#include "sim/scenario/scenario.h"
#include "sim/score/metrics.h"
#include "sim/tracking/tracking.h"

namespace sim::result {

/// Writes score.json. tracked: may be null. Throws FileError.
void write_score(const std::filesystem::path& file, const scenario::Scenario& scenario,
                 scenario::Ending ending, const score::Metrics& metrics, const tracking::Tracked* tracked,
                 const std::vector<JudgedLimit>& limits);

/// One metric of one seed, as score.json has it.
struct SeedMetric {
  std::string name, unit;
  std::optional<double> value;
};

/// What one seed left behind.
struct SeedScore {
  std::uint64_t seed = 0;
  scenario::Ending ending =
      scenario::Ending::not_started;  ///< not_started or crashed if its process left no score
  int exit_code = 0;
  std::vector<SeedMetric> metrics;
  std::string recording{};  ///< its hash; empty where it is not known

  /// Of a metric; absent also where the score does not name it.
  std::optional<double> value(const std::string& metric) const;
};

/// Reads the name of an ending. Throws FileError.
scenario::Ending read_ending(const files::Json& json);

/// Reads a score.json; the exit code is not in it. Throws FileError.
SeedScore read_score(const std::filesystem::path& file);

/// The whole of a score.json with every value of the type that this program writes. Throws FileError.
files::Json read_whole_score(const std::filesystem::path& file);

/// Reads root/seed-<n>/score.json. If the exit code shows that the run did not start or crashed, a
/// missing file is that ending. Throws FileError otherwise, and for a damaged file.
SeedScore read_seed_score(const std::filesystem::path& root, std::uint64_t seed, int exit_code);

}  // namespace sim::result
