// What is said when the user interrupts a command.
#pragma once

#include <string>

namespace cli {

/// While it lives, SIGINT (Ctrl-C), SIGTERM and SIGHUP print what the command keeps, before they end the
/// process as they do by default. One at a time.
class OnInterrupt {
 public:
  /// kept: a sentence that says what is kept and how to go on.
  explicit OnInterrupt(const std::string& kept);
  ~OnInterrupt();
  OnInterrupt(const OnInterrupt&) = delete;
  OnInterrupt& operator=(const OnInterrupt&) = delete;
};

}  // namespace cli
