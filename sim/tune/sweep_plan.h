// A sweep laid out: every configuration read and checked before anything runs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/bench/scenario.h"
#include "sim/tune/sweep_spec.h"

namespace sim::tune {

/// One scenario with one combination of values.
struct Configuration {
  bench::ReadScenario read;
  std::vector<std::string> values;  ///< of the plan's keys, as the scenario prints them
};

/// Trial i is configuration i / seeds.size() with seed i % seeds.size().
struct SweepPlan {
  std::string name;
  std::vector<std::string> keys;  ///< that are given values
  std::vector<Configuration> configurations;
  std::vector<std::uint64_t> seeds;

  std::size_t trials() const { return configurations.size() * seeds.size(); }
  /// The scenario of a trial, its seed set.
  bench::ReadScenario scenario(std::size_t trial) const;
};

/// changes: what is laid over every scenario, and sections to leave out. Throws ConfigError where a value
/// stands that its key does not take, or when there are more than a million trials.
SweepPlan plan_sweep(const SweepSpec& spec, const std::vector<std::uint64_t>& seeds,
                     const bench::Changes& changes);

}  // namespace sim::tune
