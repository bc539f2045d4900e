// Several seeds of one scenario taken together: median, mean, spread and worst of each metric, and limits on
// these.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/bench/scenario.h"
#include "sim/score/statistics.h"

namespace sim::bench {

/// One metric of one seed, as score.json has it.
struct SeedMetric {
  std::string name, unit;
  std::optional<double> value;
};

/// What one seed left behind.
struct SeedScore {
  std::uint64_t seed = 0;
  std::string ending;  ///< "not begun" (exit code 2) or "crashed" when its process left no score
  int exit_code = 0;
  std::vector<SeedMetric> metrics;
  std::string recording{};  ///< its hash; empty where it is not known
};

/// One metric over the seeds for which it is defined. Worst is the value nearest to missing the metric's
/// limit; without a limit the one of largest magnitude.
struct MetricSummary {
  std::string name, unit;
  score::Summary over_seeds;
};

/// A limit on an aggregate. A value absent because the metric is defined for no seed misses the limit, unless
/// no filter was to run: then the limit is not judged and passed is absent too.
struct JudgedLimit {
  MetricLimit limit;
  std::optional<double> value;
  std::optional<bool> passed;
};

struct Summary {
  std::string scenario;
  std::vector<SeedScore> seeds;
  std::vector<MetricSummary> metrics;
  std::vector<JudgedLimit> limits;
};

/// Reads a score.json; the exit code is not in it. Throws FileError.
SeedScore read_score(const std::filesystem::path& file);

/// Reads root/seed-<n>/score.json. A missing one is a crash when the exit code says so; a broken one is a
/// FileError.
SeedScore read_seed_score(const std::filesystem::path& root, std::uint64_t seed, int exit_code);

/// Depends on the seeds' scores alone, in the order given.
Summary summarize(const Scenario& scenario, const std::vector<SeedScore>& seeds);

/// The worst of the seeds' exit codes, and 1 when a limit over seeds is missed.
int exit_code(const Summary& summary);

/// Writes summary.json, whole or not at all. Throws FileError.
void write_summary(const std::filesystem::path& file, const Summary& summary);

/// Seeds, metrics and limits as a table for the terminal.
std::string summary_table(const Summary& summary);

}  // namespace sim::bench
