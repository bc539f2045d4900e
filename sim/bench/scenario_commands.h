// The list of walk commands: `- stand: {duration_s: 1}`, `- steps: [{left_m: -0.2, turn_deg: 5}]`, ...
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/bench/scenario_yaml.h"
#include "walking/plan.h"

namespace sim::bench {

/// Reads the whole list. Throws ConfigError at the item or field that is wrong.
void read_commands(const Yaml& node, std::string_view key, std::vector<walking::Command>& commands);

/// As YAML, one command to a line.
std::string print_commands(const std::vector<walking::Command>& commands);

/// One line for each command and its fields, for help.
std::string describe_commands();

}  // namespace sim::bench
