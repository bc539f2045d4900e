// The plan of a sweep: every configuration is read and checked before anything runs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/scenario/scenario.h"
#include "sim/tune/sweep_spec.h"

namespace sim::tune {

/// One scenario with one combination of values.
struct Configuration {
  scenario::ReadScenario read;
  std::vector<std::string> values;  ///< of the keys of the plan, as YAML on one line
};

/// Trial i is configuration i / seeds.size() with seed i % seeds.size().
struct SweepPlan {
  std::string name;
  std::vector<std::string> keys;  ///< whose values the sweep sets
  std::vector<Configuration> configurations;
  std::vector<std::uint64_t> seeds;

  std::size_t trials() const { return configurations.size() * seeds.size(); }
  /// The scenario of a trial, its seed set.
  scenario::ReadScenario scenario(std::size_t trial) const;
};

/// changes: changes of every scenario, made before those of the sweep. Throws ConfigError at a value that its
/// key does not accept, and when there are more than kMostTrials.
SweepPlan plan_sweep(const SweepSpec& spec, const std::vector<std::uint64_t>& seeds,
                     const scenario::Changes& changes);

}  // namespace sim::tune
