// What disturbs the walk: `world.pushes: [{push: {time_s: 4, impulse_ns: 10, direction_deg: 90}}]`
// and `world.floor_patches: [{patch: {x_min_m: 1, ...}}]`.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/bench/scenario_yaml.h"
#include "sim/world/options.h"

namespace sim::bench {

/// Reads a whole list, which may be empty. Throws ConfigError at the item or field that is wrong.
void read_disturbances(const Yaml& node, std::string_view key, std::vector<world::Push>& pushes);
void read_disturbances(const Yaml& node, std::string_view key, std::vector<world::FloorPatch>& patches);

/// As YAML, one item to a line.
std::string print_disturbances(const std::vector<world::Push>& pushes);
std::string print_disturbances(const std::vector<world::FloorPatch>& patches);

/// One line for each field, for help.
std::string describe_disturbances();

}  // namespace sim::bench
