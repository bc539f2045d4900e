// The table of keys: reading, overrides, help, printing, sweeps and tuning all go through it. A key's line
// stands beside the options that own it, in their function `keys`.
#pragma once

#include <string_view>
#include <vector>

#include "sim/scenario/key.h"
#include "sim/scenario/options.h"

namespace sim::scenario {

/// All keys but limits.<metric>, sections together, in the order of help and of to_yaml.
const std::vector<Key<Scenario>>& scenario_keys();

/// The key of that name, or nullptr.
const Key<Scenario>* find_key(std::string_view name);

/// The default scenario with every optional section present: where defaults are read from.
const Scenario& default_scenario();

/// True when the scenario has the section ("camera") that the key belongs to.
bool has_section(const Scenario& scenario, std::string_view key);

/// True for a key below walk, stabilizer, world or camera: what ideal sensors record depends on it. Sensor
/// errors, filter, limits and the name shape no recording; the seed does.
bool shapes_recording(std::string_view key);

/// True for a key on which what a filter estimates depends: below errors or slam, and `estimator`.
bool shapes_estimate(std::string_view key);

/// True for a key on which the recording of that scenario depends: shapes_recording(key), and in a walk that
/// is steered by its estimate also what shapes the estimate.
bool shapes_recording(const Scenario& scenario, std::string_view key);

/// The unit that a key's name ends in: "walk.step_length_m" -> "m", "gyro.sigma_rad_s" -> "rad/s"; "" for
/// none.
std::string_view unit_of(std::string_view key);

}  // namespace sim::scenario
