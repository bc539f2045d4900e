// Reading and writing scenarios: YAML files, which may change others.
#pragma once

#include <map>

#include "sim/scenario/options.h"
#include "sim/scenario/value.h"

namespace sim::scenario {

/// A scenario and the origin of each key that was set ("file:line" or "argument 2").
struct ReadScenario {
  Scenario scenario;
  std::map<std::string, std::string, std::less<>> origin;
  std::vector<Origin> command_origins = {};                ///< of each of walk.commands
  std::map<std::string, Origin, std::less<>> places = {};  ///< where each key stands that was set
  Origin start = {};                                       ///< of the file
};

/// Returns a node at the place of a key, for fail(); at the scenario's start if the file did not set the key.
Yaml place_of(const ReadScenario& read, std::string_view key);

/// A key given a value.
struct Setting {
  std::string key;
  Yaml at, value;  ///< the nodes of the key and of its value
};

/// Changes to a scenario file: overlays in the order typed, which replace keys (as the best.yaml of a tuning
/// does), then overrides "key=value", then settings, then sections to remove.
struct Changes {
  std::vector<std::string> overrides;
  std::vector<std::string> without;  ///< of "camera", "slam"
  std::vector<std::string> with{};   ///< YAML files
  std::vector<Setting> settings{};
};

/// Reads a scenario strictly; its keys replace those of the files that its key `base` names, relative to the
/// file's folder. Throws ConfigError at the first error.
ReadScenario read_scenario(const std::filesystem::path& file, const Changes& changes = {});

/// The same from text. file: its name in messages; its stem names the scenario.
ReadScenario read_scenario_text(std::string_view text, const std::string& file, const Changes& changes = {});

/// The whole scenario as YAML, without a base; reading it again gives the same scenario bit for bit. starts:
/// only keys that start with one of these.
std::string to_yaml(const Scenario& scenario, std::initializer_list<std::string_view> starts = {""});

}  // namespace sim::scenario
