// Reading and writing scenarios, which are YAML files that may build on others.
#pragma once

#include <map>

#include "sim/scenario/options.h"
#include "sim/scenario/value.h"

namespace sim::scenario {

/// A scenario and the origin of each key that was set ("file:line" or "argument 2").
struct ReadScenario {
  Scenario scenario;
  std::map<std::string, std::string, std::less<>> origin;
  std::vector<Origin> command_origins = {};                ///< for each of walk.commands
  std::map<std::string, Origin, std::less<>> places = {};  ///< origin of each key
  Origin start = {};                                       ///< start of the file
  std::vector<std::string> warnings = {};                  ///< about keys that were ignored
};

/// Returns a node at the place of a key, for fail(), or at the scenario's start if the file did not set the
/// key.
Yaml place_of(const ReadScenario& read, std::string_view key);

/// A key and its new value.
struct Setting {
  std::string key;
  Yaml at, value;  ///< the nodes of the key and of its value
};

/// Changes to a scenario file, in this order: overlays as typed, which replace keys (as a tuning's best.yaml
/// does), then overrides "key=value", then settings, then sections to remove.
struct Changes {
  std::vector<std::string> overrides;
  std::vector<std::string> without;  ///< sections: "camera", "slam"
  std::vector<std::string> with{};   ///< YAML files
  std::vector<Setting> settings{};
};

/// Reads a scenario strictly. Its keys replace the keys of the files in its key `base`, which are relative
/// to the file's folder. Throws ConfigError at the first error.
ReadScenario read_scenario(const fs::path& file, const Changes& changes = {});

/// Does the same from text. file: its name in messages; its stem names the scenario.
ReadScenario read_scenario_text(std::string_view text, const std::string& file, const Changes& changes = {});

/// Returns a session before the scenario's own, from 0, as a scenario whose result contains its map. Throws
/// ConfigError.
ReadScenario session(const ReadScenario& read, std::size_t index);

/// The whole scenario as YAML, without a base; reading it again gives the same scenario bit for bit. starts:
/// only keys that start with one of these.
std::string to_yaml(const Scenario& scenario, std::initializer_list<std::string_view> starts = {""});

}  // namespace sim::scenario
