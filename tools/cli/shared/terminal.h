// Errors of wrong usage, the chosen output, colors, and the message of an interruption.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <iosfwd>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace sim {}

namespace cli {

using namespace sim;  // only namespaces are in it
namespace fs = std::filesystem;

/// The command line is invalid. main prints the message, a text or a format with its arguments; exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  template <typename... T>
  explicit UsageError(fmt::format_string<T...> text, T&&... values)
      : std::runtime_error(fmt::format(text, std::forward<T>(values)...)) {}
};

/// Exit code if the disk is full or a device failed: EX_IOERR of sysexits.h.
inline constexpr int kDeviceFailed = 74;
/// The start of each error message that has no place in a file.
inline constexpr std::string_view kProgramPrefix = "gaitslam: ";

/// text: for people. quiet: nothing but errors, on standard error. json: one JSON document and nothing else.
enum class Output { text, quiet, json };

Output output();
void choose_output(Output output);

/// Returns the stream of text for people: standard output, or none with --quiet or --json.
std::ostream& text_out();

/// Returns whether a stream (STDOUT_FILENO, STDERR_FILENO) is a terminal that can redraw lines.
bool can_redraw(int stream);
/// Returns whether standard output is a terminal with colors and NO_COLOR is not set.
bool colors();

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
