// The table of keys for reading, overrides, help, printing, sweeps and tuning. A key's line is in the
// function `keys` of the options struct that owns it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/scenario/key.h"
#include "sim/scenario/options.h"

namespace sim::scenario {

/// All keys but limits.<metric>, sections together, in the order of help and of to_yaml.
const std::vector<Key>& scenario_keys();

/// The key of that name, or nullptr.
const Key* find_key(std::string_view name);

/// Returns "was renamed to NAME" for a former name, "" for any other.
std::string former_name(std::string_view name);

/// Returns the error for a name that is not a key: its present name if it is a former one, else the nearest
/// key.
std::string unknown_key(std::string_view name);

/// The default scenario with all optional sections, the source of defaults.
const Scenario& default_scenario();

/// True if the scenario has the section ("camera") of the key.
bool has_section(const Scenario& scenario, std::string_view key);

/// True for a key that shapes what ideal sensors record: below walk, stabilizer, world or camera. The seed
/// does, too.
bool shapes_recording(std::string_view key);

/// True for a key that shapes the estimates of a filter: below errors or slam, `estimator`, and below
/// estimator.time.
bool shapes_estimate(std::string_view key);

/// True for a key that shapes the recording of that scenario: shapes_recording(key), and if the estimate
/// steers the walk also shapes_estimate(key).
bool shapes_recording(const Scenario& scenario, std::string_view key);

/// Returns the unit in a key's name: "walk.step_length_m" -> "m", "gyro.sigma_rad_s" -> "rad/s"; "" without
/// one.
std::string_view unit_of(std::string_view key);

}  // namespace sim::scenario
