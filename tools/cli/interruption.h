// What is said when the user interrupts a command.
#pragma once

#include <string>

namespace cli {

/// Keeps the command line as the user typed it, to be called by main.
void remember_command(int argc, char** argv);

/// While it lives, SIGINT (Ctrl-C), SIGTERM and SIGHUP print what the command keeps, before they end the
/// process as they do by default, and how to go on: the very same command. One at a time.
class OnInterrupt {
 public:
  /// kept: what is kept and what the same command does, to be followed by that command.
  explicit OnInterrupt(const std::string& kept);
  ~OnInterrupt();
  OnInterrupt(const OnInterrupt&) = delete;
  OnInterrupt& operator=(const OnInterrupt&) = delete;
};

}  // namespace cli
