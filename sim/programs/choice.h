// The value of a scenario key that selects something built-in or an external program.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace sim::programs {

/// The source of answers. command: a program that ran on an exported recording (gaitslam evaluate).
enum class Source { built_in, program, command };

/// The program or built-in that a key selects.
struct Choice {
  Source source = Source::built_in;
  std::string name = {};                ///< name of the built-in, or the program's name in results
  std::vector<std::string> words = {};  ///< program and arguments, or the whole command as one word
  std::vector<std::pair<std::string, std::string>> options = {};  ///< passed to a program
  double start_within_s = 60, answer_within_s = 10;               ///< time limits for a program

  bool operator==(const Choice&) const = default;
};

/// Throws std::invalid_argument if the program or its interpreter is missing. Does not start it. role:
/// "estimator".
void require_program(const Choice& choice, const std::string& role);

/// Returns the words of a program, or a command split at white space.
std::vector<std::string> command_words(const Choice& choice);

/// Returns the name of a command: the file name of its program, or of the script run by an interpreter or a
/// wrapper such as `env`, without folder and extension.
std::string program_name(const std::vector<std::string>& words);

/// Returns hashes of the files named in the words and the option values; the program is looked up in PATH.
/// Other files, such as modules of a script, are not included.
std::string files_identity(const Choice& choice);

/// Returns the options, one line "key=value" each.
std::string options_text(const Choice& choice);

}  // namespace sim::programs
