// What shapes a recording: its name in the cache is a hash of that, and a replay cannot change it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "sim/scenario/scenario.h"

namespace sim::tune {

/// One hash (32 hexadecimal digits) of the models' files: names and contents. Throws FileError.
std::string models_hash(const std::filesystem::path& models);

/// A hash (32 hexadecimal digits) of the scenario's keys that shape recordings
/// (scenario::shapes_recording), its seed, whether it has a camera, the models and the program. Limits and
/// name are not in it, nor are sensor errors and filter unless the walk is steered by its estimate. program:
/// what tells the programs apart that may record other bits.
std::string recording_key(const scenario::Scenario& scenario, const std::string& models_hash,
                          const std::string& program);

/// A key that shapes recordings and differs, with its value in the recording and now ("left out" where the
/// scenario does not have that section).
struct RecordingDifference {
  std::string key, recorded, now;
};
/// The first key of the recorded scenario that shapes recordings and has another value in `scenario`: a
/// replay cannot change it.
std::optional<RecordingDifference> first_difference(const scenario::Scenario& recorded,
                                                    const scenario::Scenario& scenario);

/// Why this scenario, which has slam, would not have made the recorded walk: that was steered by an estimate,
/// and here the estimate is another. Empty where it would have. A replay is possible, but what it estimates
/// steered nothing.
std::string counterfactual(const scenario::Scenario& recorded, const scenario::Scenario& scenario);

}  // namespace sim::tune
