// Scenarios for tests: short ones, with their errors; all files in scenarios/; and non-default values of
// keys.
#pragma once

#include "sim/scenario/keys.h"
#include "sim/scenario/scenario.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::scenario {

inline ReadScenario read_text(const std::string& text, const Changes& changes = {}) {
  return read_scenario_text(text, "test.yaml", changes);
}

inline std::string complaint(const std::string& text, const Changes& changes = {}) {
  return files::error_of([&] { read_text(text, changes); });
}

inline const std::string kWalk = "walk: {commands: [{stand: {duration_s: 1}}]}\n";
inline const std::string kAll = kWalk + "camera: {}\nslam: {}\n";

/// Returns the default scenario with a different value of that key: the first of many candidates that it
/// accepts.
inline std::optional<Scenario> changed(const Key& key) {
  constexpr std::string_view kOneOf = "one of ";
  std::string texts =
      "true, false, 37, 20000, 3, 0.0625, 0.3, 0.7, 2.5, 0.004, 1e5, 1, [fell], [[1; 2; 3]], "
      "{program: [./mine]; options: {a: {b: 1}}}, [{stand: {duration_s: 2}}], [{gyro_silent: {}}], [{door: "
      "{x_m: 1}}], "
      "[{push: {time_s: 1; impulse_ns: 3}}], "
      "[{patch: {x_min_m: 1; x_max_m: 2; y_min_m: 1; y_max_m: 2; friction: 0.3}}], [0.1; 0.2; 0.3], [d435i], "
      "[{session: {set: [world.start.x_m=1]}}]";
  if (key.expected.starts_with(kOneOf)) texts = key.expected.substr(kOneOf.size());
  std::istringstream in(texts);
  for (std::string text; std::getline(in, text, ',');) {
    std::ranges::replace(text, ';', ',');
    Scenario scenario = default_scenario();
    if (!files::error_of([&] { key.read(parse_yaml(text, {"test"}), scenario); }).empty()) continue;
    if (key.print(scenario) != key.print(default_scenario())) return scenario;
  }
  return std::nullopt;
}

inline fs::path scenario_folder() { return fs::path(GAITSLAM_SOURCE_DIR) / "scenarios"; }

/// Files in scenarios/suites, scenarios/studies and scenarios/tuning are not scenarios; files in
/// scenarios/bases are parts of scenarios.
/// scenarios/bases are parts.
inline std::vector<fs::path> scenario_files() {
  const std::set<std::string> others{"suites", "studies", "tuning", "bases"};
  std::vector<fs::path> files;
  for (const fs::path& file : fs::recursive_directory_iterator(scenario_folder()))
    if (file.extension() == ".yaml" && !others.contains(file.parent_path().filename())) files.push_back(file);
  std::ranges::sort(files);
  return files;
}

/// Returns the file's stem.
inline std::string test_name(const testing::TestParamInfo<fs::path>& test) {
  std::string name = test.param.lexically_relative(scenario_folder()).replace_extension().string();
  std::ranges::replace(name, '/', '_');
  return name;
}

}  // namespace sim::scenario
