// The determinants of a recording: the hash that names it in the cache, and the keys that a replay cannot
// change.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "sim/scenario/scenario.h"

namespace sim::scenario {

/// A hash (32 hexadecimal digits) of the names and contents of the models' files. Throws FileError.
std::string models_hash(const std::filesystem::path& models);

/// A hash (32 hexadecimal digits) of the keys that shape the scenario's recording (shapes_recording), its
/// seed, whether it has a camera, the models, and `program`, which identifies programs that record other
/// bits.
std::string recording_key(const Scenario& scenario, const std::string& models_hash,
                          const std::string& program);

/// A key that shapes recordings and differs, with its value in the recording and now ("left out" if the
/// scenario does not have that section).
struct RecordingDifference {
  std::string key, recorded, now;
};
/// The first key that shapes recordings and has another value in `scenario` than in the recorded one.
std::optional<RecordingDifference> first_difference(const Scenario& recorded, const Scenario& scenario);

/// Why a replay with this scenario, which has slam, would have steered another walk than was recorded: an
/// estimate steered that walk, and now it is another. Empty otherwise.
std::string counterfactual(const Scenario& recorded, const Scenario& scenario);

}  // namespace sim::scenario
