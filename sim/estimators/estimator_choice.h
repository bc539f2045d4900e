// The value of the scenario's key `estimator`: a built-in estimator or an external program.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace sim::estimators {

/// Source of an estimator. command: a program that ran on an exported recording (gaitslam evaluate).
enum class Source { built_in, program, command };

/// The chosen estimator.
struct EstimatorChoice {
  Source source = Source::built_in;
  std::string name = "filter";     ///< of a built-in one; else its name in results
  std::vector<std::string> words;  ///< program and arguments, or one word with the command
  std::vector<std::pair<std::string, std::string>> options;  ///< passed to a program
  double start_within_s = 60, answer_within_s = 10;          ///< time limits of a program

  bool operator==(const EstimatorChoice&) const = default;
};

/// Throws std::invalid_argument for a missing program, without starting it.
void require_program(const EstimatorChoice& choice);

/// Returns the words of a program, or those of a command between white space.
std::vector<std::string> command_words(const EstimatorChoice& choice);

/// Returns hashes of the files that the words name; the program is searched in PATH. Files that no word
/// names, such as modules of a script, are not included.
std::string estimator_files_identity(const EstimatorChoice& choice);

}  // namespace sim::estimators
