// What a sweep is to try: scenarios, seeds, and the values of keys, from a file and from the command line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/bench/scenario_yaml.h"

namespace sim::tune {

/// A key given a value.
struct Setting {
  std::string key;
  bench::Yaml at, value;  ///< where the key stands, and its value
};
/// Settings that go together, and alternatives to each other.
using Point = std::vector<Setting>;
using Axis = std::vector<Point>;

/// A sweep tries every combination of one point of each axis, on every scenario and every seed.
struct SweepSpec {
  std::string name;  ///< the file's stem
  std::vector<std::filesystem::path> scenarios;
  bench::Yaml seeds;  ///< as users type them, "1..5"; empty: not said
  std::vector<Axis> axes;
};

/// How distributions (uniform(a, b), loguniform(a, b)) of the command line are sampled.
struct Sampling {
  int points = 16;
  std::string method = "sobol";  ///< or "random"
  std::uint64_t seed = 0;
};

/// A spec's file (keys scenario or scenarios, seeds, grid, zip, sample), or a scenario's, which is then the
/// only one; and arguments KEY=VALUES, zip(KEY=VALUES, KEY=VALUES). Throws ConfigError at the first thing
/// that is not as it should be; values are not tried yet.
SweepSpec read_sweep(const std::filesystem::path& file, const std::vector<std::string>& arguments,
                     const Sampling& sampling);

}  // namespace sim::tune
