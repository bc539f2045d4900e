// What a sweep tries: scenarios, seeds, and values of keys, from a file and from the command line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/scenario/yaml.h"

namespace sim::tune {

/// A key given a value.
struct Setting {
  std::string key;
  scenario::Yaml at, value;  ///< the nodes of the key and of its value
};
/// Settings that are made together.
using Point = std::vector<Setting>;
/// Points that are alternatives to each other.
using Axis = std::vector<Point>;

/// A sweep tries every combination of one point of each axis on every scenario and every seed.
struct SweepSpec {
  std::string name;  ///< the file's stem
  std::vector<std::filesystem::path> scenarios;
  std::vector<std::uint64_t> seeds;  ///< empty: not given
  std::vector<Axis> axes;
};

/// How the distributions uniform(a, b) and loguniform(a, b) are sampled.
struct Sampling {
  int points = 16;
  std::string method = "sobol";  ///< or "random"
  std::uint64_t seed = 0;
};

/// Reads a sweep's file (keys scenario or scenarios, seeds, grid, zip, sample) or a scenario's file, which is
/// then the only scenario; and the arguments KEY=VALUES and zip(KEY=VALUES, KEY=VALUES), whose distributions
/// are sampled as `sampling` says. Throws ConfigError at the first fault; whether a key accepts its values is
/// checked by plan_sweep.
SweepSpec read_sweep(const std::filesystem::path& file, const std::vector<std::string>& arguments,
                     const Sampling& sampling);

}  // namespace sim::tune
