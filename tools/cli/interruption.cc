#include "tools/cli/interruption.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "sim/files/printed_text.h"

namespace cli {
namespace {

constexpr std::array kInterrupts{SIGINT, SIGTERM, SIGHUP};

// Written before the handler is installed, since a handler may do little more than write bytes.
std::array<char, 8192> said_at_interrupt;
volatile sig_atomic_t said_bytes = 0;

std::string& typed_command() {
  static std::string command = "gaitslam";
  return command;
}

extern "C" void say_and_end(int signal_number) {
  [[maybe_unused]] const ssize_t n =
      ::write(STDERR_FILENO, said_at_interrupt.data(), static_cast<std::size_t>(said_bytes));
  ::signal(signal_number, SIG_DFL);
  ::raise(signal_number);  // it ends the process when this handler returns
}

// Replaces one handler by another; one that ignores the signal, as that of nohup, stays.
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
  const std::size_t bytes = std::min(text.size(), said_at_interrupt.size());
  std::copy_n(text.begin(), bytes, said_at_interrupt.begin());
  said_bytes = static_cast<sig_atomic_t>(bytes);
  exchange_handlers(SIG_DFL, say_and_end);
}

OnInterrupt::~OnInterrupt() { exchange_handlers(say_and_end, SIG_DFL); }

}  // namespace cli
