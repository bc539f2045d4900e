#include "tools/cli/shared/interruption.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "sim/files/text.h"

namespace cli {
namespace {

constexpr std::array kInterrupts{SIGINT, SIGTERM, SIGHUP};

// Filled before the handler is installed, which may only call async-signal-safe functions.
std::array<char, 8192> text_at_interrupt;
volatile sig_atomic_t text_bytes = 0;

std::string& typed_command() {
  static std::string command = "gaitslam";
  return command;
}

extern "C" void print_and_end(int signal_number) {
  [[maybe_unused]] const ssize_t n =
      ::write(STDERR_FILENO, text_at_interrupt.data(), static_cast<std::size_t>(text_bytes));
  ::signal(signal_number, SIG_DFL);
  ::raise(signal_number);  // it ends the process when this handler returns
}

// Replaces one handler by another, but none that ignores the signal, as nohup sets.
void exchange_handlers(void (*from)(int), void (*to)(int)) {
  for (const int signal_number : kInterrupts) {
    struct sigaction now {};
    if (::sigaction(signal_number, nullptr, &now) == 0 && now.sa_handler == from) ::signal(signal_number, to);
  }
}

}  // namespace

void remember_command(int argc, char** argv) {
  const char* const launcher = std::getenv("GAITSLAM_TYPED_AS");  // set by tools/gaitslam
  std::string command = sim::files::shell_word(launcher ? launcher : argv[0]);
  for (int i = 1; i < argc; ++i) command += " " + sim::files::shell_word(argv[i]);
  typed_command() = command;
}

OnInterrupt::OnInterrupt(const std::string& kept) {
  const std::string text = fmt::format("{}gaitslam: interrupted: {}:\n  {}\n",
                                       isatty(STDERR_FILENO) == 1 ? "\n" : "", kept, typed_command());
  const std::size_t bytes = std::min(text.size(), text_at_interrupt.size());
  std::copy_n(text.begin(), bytes, text_at_interrupt.begin());
  text_bytes = static_cast<sig_atomic_t>(bytes);
  exchange_handlers(SIG_DFL, print_and_end);
}

OnInterrupt::~OnInterrupt() { exchange_handlers(print_and_end, SIG_DFL); }

}  // namespace cli
