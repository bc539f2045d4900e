// Errors of the reader of scenarios, for tests.
#pragma once

#include <string>

#include "sim/scenario/scenario.h"
#include "sim/scenario/yaml.h"

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

}  // namespace sim::scenario
