// Commands of a POSIX shell.
#pragma once

#include <string>

namespace cli {

/// What a shell command printed on standard output and standard error, and its exit status.
struct ShellOutput {
  std::string text;
  int status = 0;
};

/// Runs a shell command to its end. Throws UsageError when it cannot be started.
ShellOutput run_shell(const std::string& command);

}  // namespace cli
