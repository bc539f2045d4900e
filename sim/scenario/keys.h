// The table of keys for reading, overrides, help, printing, sweeps and tuning.
#pragma once

#include <filesystem>
#include <optional>
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

/// Returns the error for a name that is not a key: the present name of a former one, else the nearest key.
std::string unknown_key(std::string_view name);

/// The default scenario with all optional sections, the source of defaults.
const Scenario& default_scenario();

/// True if the scenario has the section ("camera") of the key.
bool has_section(const Scenario& scenario, std::string_view key);

/// True for a key that shapes what ideal sensors record, as does the seed: walk, stabilizer, world, camera.
bool shapes_recording(std::string_view key);

/// True for a key that shapes the estimates of a filter: below errors or slam, `estimator`, and below
/// estimator.time.
bool shapes_estimate(std::string_view key);

/// True for a key that shapes that scenario's recording; if the estimate steers, shapes_estimate() too.
bool shapes_recording(const Scenario& scenario, std::string_view key);

/// Returns the unit in a key's name, "m" for "walk.step_length_m"; "" without one.
std::string unit_of(std::string_view key);

/// A hash (32 hexadecimal digits) of the names and contents of the models' files. Throws FileError.
std::string models_hash(const std::filesystem::path& models);

/// A hash (32 hexadecimal digits) of the keys that shape a scenario's recording (shapes_recording), its seed,
/// whether it has a camera, the models, and `program`, which stands for programs that record other bits.
std::string recording_key(const Scenario& scenario, const std::string& models, const std::string& program);

/// A key that shapes recordings and differs, with its value there and now ("left out" without its section).
struct RecordingDifference {
  std::string key, recorded, now;
};
/// The first key that shapes recordings and has another value in `scenario` than in the recorded one.
std::optional<RecordingDifference> first_difference(const Scenario& recorded, const Scenario& scenario);

/// Why a replay with this scenario, which has slam, would have steered another walk than was recorded: an
/// estimate steered that walk, and now it is another. Empty otherwise.
std::string counterfactual(const Scenario& recorded, const Scenario& scenario);

// Limits on metrics: `ate_se3_rmse_m: {at_most: 0.1}`, `ate_se3_rmse_m.median: {at_most: 0.05}`.

/// Returns the error for an unknown metric: the present name of a former one, else the nearest metric.
std::string unknown_metric(std::string_view name);

/// Reads limits.<metric>[.<aggregate>].<bound> (the key), replacing an earlier one. Throws ConfigError.
void read_limit(const Yaml& at, const std::string& key, const Yaml& value, std::vector<MetricLimit>& limits);

/// True if the value satisfies the limit.
bool keeps(const MetricLimit& limit, double value);

/// "ate_se3_rmse_m.median"
std::string subject(const MetricLimit& limit);
/// "at_most" or "at_least"
std::string_view word(Bound bound);

}  // namespace sim::scenario
