// Which estimator a scenario names: one that is built in, or somebody's program or library.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace sim::estimators {

/// Where an estimator comes from. command: a program that was run on an exported recording (gaitslam
/// evaluate).
enum class Source { built_in, program, library, command };

/// The value of the scenario's key `estimator`.
struct EstimatorChoice {
  Source source = Source::built_in;
  std::string name = "filter";     ///< of a built-in one; else what results call it
  std::vector<std::string> words;  ///< program and arguments; or alone the library's file, or the command
  std::vector<std::pair<std::string, std::string>> options;  ///< told to a program or library
  double start_within_s = 60, answer_within_s = 10;          ///< time limits of a program

  bool operator==(const EstimatorChoice&) const = default;
};

}  // namespace sim::estimators
