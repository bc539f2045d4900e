// Words and commands of a POSIX shell.
#pragma once

#include <string>

namespace cli {

/// The text as one word of a shell command, in quotes where that is needed.
std::string shell_word(const std::string& text);

/// What a shell command printed on standard output and standard error, and its exit status.
struct ShellOutput {
  std::string text;
  int status = 0;
};

/// Runs a shell command to its end. Throws UsageError when it cannot be started.
ShellOutput run_shell(const std::string& command);

}  // namespace cli
