// Usage errors, the chosen output, colors, and the message printed on interruption.
#pragma once

#include <fmt/format.h>
#include <signal.h>

#include <filesystem>
#include <iosfwd>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace sim {}

namespace cli {

using namespace sim;  // it contains only namespaces
namespace fs = std::filesystem;

/// An invalid command line, described by a text or a format with arguments; main prints it and exits with
/// code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  template <typename... T>
  explicit UsageError(fmt::format_string<T...> text, T&&... values)
      : std::runtime_error(fmt::format(text, std::forward<T>(values)...)) {}
};

/// Exit code if the disk is full or a device failed: EX_IOERR of sysexits.h.
inline constexpr int kDeviceFailed = 74;
/// Prefix of each error message that does not refer to a location in a file.
inline constexpr std::string_view kProgramPrefix = "gaitslam: ";

/// text: for people. quiet: only errors, on standard error. json: one JSON document and nothing else.
enum class Output { text, quiet, json };

Output output();
void choose_output(Output output);

/// Returns the stream of text for people: standard output, or none with --quiet or --json.
std::ostream& text_out();

/// Returns whether a stream (STDOUT_FILENO, STDERR_FILENO) is a terminal that can redraw lines.
bool can_redraw(int stream);
/// Returns whether standard output is a terminal with colors and NO_COLOR is not set.
bool colors();

/// Stores the command line as the user typed it; called by main.
void remember_command(int argc, char** argv);
/// Returns the program as the user typed it, as a word for a shell.
const std::string& typed_program();

/// While an object lives, SIGINT (Ctrl-C), SIGTERM and SIGHUP print which results are kept and the command
/// line that resumes the command, and then end the process as usual. Only one object may exist at a time.
class OnInterrupt {
 public:
  /// kept: text that states what is kept and introduces the command line printed after it.
  explicit OnInterrupt(const std::string& kept);
  ~OnInterrupt();
  /// Sets the text that follows, which may be empty.
  static void add(const std::string& text);
  OnInterrupt(const OnInterrupt&) = delete;
  OnInterrupt& operator=(const OnInterrupt&) = delete;
};

/// While an object lives, SIGINT, SIGTERM and SIGHUP are blocked in this thread and in threads started by it.
class BlockedInterrupts {
 public:
  BlockedInterrupts();
  ~BlockedInterrupts();
  BlockedInterrupts(const BlockedInterrupts&) = delete;
  BlockedInterrupts& operator=(const BlockedInterrupts&) = delete;
  /// Waits for one of them.
  void wait() const;
  /// Returns whether one of them has arrived.
  bool pending() const;

 private:
  sigset_t signals_{}, before_{};
};

}  // namespace cli
