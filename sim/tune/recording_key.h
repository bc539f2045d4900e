// The name of a recording in the cache: a hash of all that shapes it.
#pragma once

#include <filesystem>
#include <string>

#include "sim/bench/scenario.h"

namespace sim::tune {

/// One hash (32 hexadecimal digits) of the models' files: names and contents. Throws FileError.
std::string models_hash(const std::filesystem::path& models);

/// A hash (32 hexadecimal digits) of the scenario's keys that shape recordings
/// (bench::shapes_recording), its seed, whether it has a camera, the models and the program. Sensor
/// errors, filter, limits and name are not in it. program: what tells the programs apart that may record
/// other bits.
std::string recording_key(const bench::Scenario& scenario, const std::string& models_hash,
                          const std::string& program);

}  // namespace sim::tune
