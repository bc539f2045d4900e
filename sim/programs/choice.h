// The value of a scenario's key that names something built-in or an external program.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace sim::programs {

/// Source of an answer. command: a program that ran on an exported recording (gaitslam evaluate).
enum class Source { built_in, program, command };

/// The choice.
struct Choice {
  Source source = Source::built_in;
  std::string name = {};                ///< of something built-in; else its name in results
  std::vector<std::string> words = {};  ///< program and arguments, or one word with the command
  std::vector<std::pair<std::string, std::string>> options = {};  ///< passed to a program
  double start_within_s = 60, answer_within_s = 10;               ///< time limits of a program

  bool operator==(const Choice&) const = default;
};

/// Throws std::invalid_argument for a missing program, without starting it. role: "estimator".
void require_program(const Choice& choice, const std::string& role);

/// Returns the words of a program, or those of a command between white space.
std::vector<std::string> command_words(const Choice& choice);

/// Returns the file, without folder and extension, that names a command: the program's, or that of the script
/// that an interpreter or a wrapper such as `env` runs.
std::string program_name(const std::vector<std::string>& words);

/// Returns hashes of the files that words and values of options name; the program is searched in PATH.
/// Other files, such as modules of a script, are not included.
std::string files_identity(const Choice& choice);

/// Returns the options as lines "key=value".
std::string options_text(const Choice& choice);

}  // namespace sim::programs
