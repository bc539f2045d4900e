// How a walk, an estimate or a run ended: one table of names and exit codes.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
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

/// exit_code: of a run whose scenario does not allow the ending.
struct EndingRow {
  std::string_view name;
  int exit_code;
};

/// In the order of the enumerators.
inline constexpr std::array<EndingRow, 10> kEndings{{{"completed", 3},
                                                     {"fell", 3},
                                                     {"collided", 3},
                                                     {"diverged", 3},
                                                     {"stopped", 3},
                                                     {"estimator_failed", 3},
                                                     {"sensor_unused", 3},
                                                     {"failed", 3},
                                                     {"crashed", 3},
                                                     {"not started", 2}}};

/// The names of the endings that a result can have: all but the last two.
inline constexpr auto kResultEndings = [] {
  std::array<std::string_view, kEndings.size() - 2> names{};
  std::transform(kEndings.begin(), kEndings.end() - 2, names.begin(),
                 [](const EndingRow& row) { return row.name; });
  return names;
}();

constexpr std::string_view name_of(Ending ending) { return kEndings[static_cast<std::size_t>(ending)].name; }
constexpr int exit_code_of(Ending ending) { return kEndings[static_cast<std::size_t>(ending)].exit_code; }

/// Returns the ending of this name, or nullopt.
constexpr std::optional<Ending> ending_named(std::string_view name) {
  for (std::size_t i = 0; i < kEndings.size(); ++i)
    if (kEndings[i].name == name) return static_cast<Ending>(i);
  return std::nullopt;
}

/// An ending and its cause in words; a completed run has none.
struct Ended {
  Ending ending = Ending::not_started;
  std::string cause = {};
};

}  // namespace sim::scenario
