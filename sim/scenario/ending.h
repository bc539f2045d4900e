// How a walk, an estimate or a run ended: names and exit codes.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sim::scenario {

/// stopped: a steered walk had no estimate for too long. estimator_failed: the estimator crashed, missed a
/// time limit or gave an invalid answer. sensor_unused: the filter did not use one of its sensors in any
/// frame. failed: the simulator broke, which no scenario can allow. crashed,
/// not_started: the process of the run left no result.
enum class Ending {
  completed,
  fell,
  collided,
  diverged,
  stopped,
  estimator_failed,
  sensor_unused,
  failed,
  crashed,
  not_started
};

/// In the order of the enumerators.
inline constexpr std::array<std::string_view, 10> kEndings{
    "completed",        "fell",          "collided", "diverged", "stopped",
    "estimator_failed", "sensor_unused", "failed",   "crashed",  "not started"};

/// The names of the endings that a result can have.
inline constexpr auto kResultEndings = std::span(kEndings).first<8>();

constexpr std::string_view name_of(Ending ending) { return kEndings[static_cast<std::size_t>(ending)]; }

/// Returns the exit code of a run if its scenario does not allow the ending.
constexpr int exit_code_of(Ending ending) { return ending == Ending::not_started ? 2 : 3; }

/// Returns the ending of this name, or nullopt.
constexpr std::optional<Ending> ending_named(std::string_view name) {
  const auto found = std::find(kEndings.begin(), kEndings.end(), name);
  if (found == kEndings.end()) return std::nullopt;
  return static_cast<Ending>(found - kEndings.begin());
}

/// An ending and its cause in words; a completed run has none.
struct Ended {
  Ending ending = Ending::not_started;
  std::string cause = {};
};

}  // namespace sim::scenario
