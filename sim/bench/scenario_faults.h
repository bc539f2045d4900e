// The list of sensor faults: `- frames_lost: {from_s: 20, duration_s: 2}`, `- gyro_spike: {size_rad_s: 5}`,
// ...
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/bench/scenario_yaml.h"
#include "sim/stream/faults.h"

namespace sim::bench {

/// Reads the whole list. Throws ConfigError at the item or field that is wrong.
void read_faults(const Yaml& node, std::string_view key, std::vector<stream::Fault>& faults);

/// As YAML, one fault to a line.
std::string print_faults(const std::vector<stream::Fault>& faults);

/// One line for each kind of fault and its fields, for help.
std::string describe_faults();

}  // namespace sim::bench
