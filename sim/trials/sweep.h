// A sweep: every combination of values on every scenario and seed, checked before anything runs; and its
// scores.
#pragma once

#include <functional>
#include <vector>

#include "sim/result/job_log.h"
#include "sim/scenario/scenario.h"

namespace sim::trials {

using result::JobLog, result::JobRecord;

using scenario::Setting;
/// Settings that are applied together.
using Point = std::vector<Setting>;
/// Points that are alternatives to each other.
using Axis = std::vector<Point>;

struct SweepSpec {
  std::string name;  ///< the file's stem
  std::vector<fs::path> scenarios;
  std::vector<std::uint64_t> seeds;  ///< empty: not given
  std::vector<Axis> axes;
};

/// The maximum number of trials of a sweep.
inline constexpr std::size_t kMostTrials = 100'000;

/// Reads a sweep file (scenario or scenarios, seeds, parameters, samples) or a scenario file, and arguments
/// such as KEY=VALUE,VALUE. Ranges without points share `samples` Sobol samples, 16 by default. Throws
/// ConfigError at the first error, but does not check yet whether keys accept their values.
SweepSpec read_sweep(const fs::path& file, const std::vector<std::string>& arguments,
                     std::optional<int> samples = std::nullopt);

/// One scenario with one combination of values.
struct Configuration {
  scenario::ReadScenario read;
  std::vector<std::string> values;  ///< values of the plan's keys, as YAML on one line
  std::vector<std::string> labels;  ///< the same for display: an estimator or a controller by its name
};

/// Trial i is configuration i / seeds.size() with seed i % seeds.size().
struct SweepPlan {
  std::string name;
  std::vector<std::string> keys;  ///< keys that the sweep sets
  std::vector<Configuration> configurations;
  std::vector<std::uint64_t> seeds;

  std::size_t trials() const { return configurations.size() * seeds.size(); }
  /// Returns the scenario of a trial with its seed.
  scenario::ReadScenario scenario(std::size_t trial) const;
};

/// Returns the plan of a sweep, with the changes applied first to every scenario. Throws ConfigError at a
/// value that its key does not accept, or if there are more than kMostTrials.
SweepPlan plan_sweep(const SweepSpec& spec, const std::vector<std::uint64_t>& seeds,
                     const scenario::Changes& changes);

/// Returns the record of the plan's i-th trial, or nullptr if there is none.
using RecordOf = std::function<const JobRecord*(std::size_t)>;

/// A line for each trial that has a record: of CSV (RFC 4180), after a line of titles, and of JSON.
struct Scores {
  std::string csv, jsonl;
};
Scores scores(const SweepPlan& plan, const RecordOf& record);

/// Returns medians over the seeds for each of the first forty configurations.
std::string sweep_table(const SweepPlan& plan, const RecordOf& record);

}  // namespace sim::trials
