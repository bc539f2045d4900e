// Errors of the reader of scenarios, and other values of keys, for tests.
#pragma once

#include <sstream>

#include "sim/scenario/keys.h"
#include "sim/scenario/scenario.h"

namespace sim::scenario {

inline ReadScenario read_text(const std::string& text, const Changes& changes = {}) {
  return read_scenario_text(text, "test.yaml", changes);
}

/// Returns the message of the ConfigError that `read` throws, or "".
template <class Read>
std::string complaint_of(const Read& read) {
  try {
    read();
    return "";
  } catch (const ConfigError& e) {
    return e.what();
  }
}

inline std::string complaint(const std::string& text, const Changes& changes = {}) {
  return complaint_of([&] { read_text(text, changes); });
}

inline const std::string kWalk = "walk: {commands: [{stand: {duration_s: 1}}]}\n";
inline const std::string kAll = kWalk + "camera: {}\nslam: {}\n";

/// The default scenario with another value of that key: the first of many that it takes.
inline std::optional<Scenario> changed(const Key& key) {
  constexpr std::string_view kOneOf = "one of ";
  std::string texts =
      "true, false, 37, 20000, 3, 0.0625, 0.3, 0.7, 2.5, 0.004, 1e5, 1, [fell], [[1; 2; 3]], "
      "{program: [./mine]; options: {a: {b: 1}}}, [{stand: {duration_s: 2}}], [{gyro_silent: {}}], "
      "[{push: {time_s: 1; impulse_ns: 3}}], "
      "[{patch: {x_min_m: 1; x_max_m: 2; y_min_m: 1; y_max_m: 2; friction: 0.3}}], [0.1; 0.2; 0.3], [d435i]";
  if (key.expected.starts_with(kOneOf)) texts = key.expected.substr(kOneOf.size());
  std::istringstream in(texts);
  for (std::string text; std::getline(in, text, ',');) {
    std::replace(text.begin(), text.end(), ';', ',');
    Scenario scenario = default_scenario();
    if (!complaint_of([&] { key.read(parse_yaml(text, {"test"}), scenario); }).empty()) continue;
    if (key.print(scenario) != key.print(default_scenario())) return scenario;
  }
  return std::nullopt;
}

}  // namespace sim::scenario
