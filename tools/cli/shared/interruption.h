// Message of an interrupted command.
#pragma once

#include <string>

namespace cli {

/// Keeps the command line as the user typed it; called by main.
void remember_command(int argc, char** argv);

/// While it lives, SIGINT (Ctrl-C), SIGTERM and SIGHUP print what the command keeps and the command line that
/// resumes it, before they end the process as they do by default. One at a time.
class OnInterrupt {
 public:
  /// kept: what is kept and what the command line that follows does.
  explicit OnInterrupt(const std::string& kept);
  ~OnInterrupt();
  OnInterrupt(const OnInterrupt&) = delete;
  OnInterrupt& operator=(const OnInterrupt&) = delete;
};

}  // namespace cli
