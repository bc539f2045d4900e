#include "tools/cli/shared/terminal.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iostream>

#include "sim/files/text.h"

namespace cli {
namespace {

Output chosen = Output::text;
std::string program = "gaitslam", typed_command = program;

// Filled before the handler is installed, because the handler may call only async-signal-safe functions.
std::array<char, 8192> text_at_interrupt;
volatile sig_atomic_t text_bytes = 0;
std::size_t own_bytes = 0;  // without what add() added

extern "C" void print_and_end(int signal_number) {
  [[maybe_unused]] const ssize_t n =
      ::write(STDERR_FILENO, text_at_interrupt.data(), std::size_t(text_bytes));
  ::signal(signal_number, SIG_DFL);
  ::raise(signal_number);  // ends the process when this handler returns
}

// Replaces the handler `from` with `to`, but does not touch signals that are ignored, for example by nohup.
void exchange_handlers(void (*from)(int), void (*to)(int)) {
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction now {};
    if (::sigaction(signal_number, nullptr, &now) == 0 && now.sa_handler == from) ::signal(signal_number, to);
  }
}

}  // namespace

Output output() { return chosen; }

void choose_output(Output output) { chosen = output; }

std::ostream& text_out() {
  static std::ostream nowhere(nullptr);
  return chosen == Output::text ? std::cout : nowhere;
}

bool can_redraw(int stream) {
  const char* const kind = std::getenv("TERM");
  return isatty(stream) == 1 && kind && std::string_view(kind) != "dumb";
}

bool colors() {
  const char* const unwanted = std::getenv("NO_COLOR");
  return can_redraw(STDOUT_FILENO) && (!unwanted || *unwanted == '\0');
}

void remember_command(int argc, char** argv) {
  const char* const launcher = std::getenv("GAITSLAM_TYPED_AS");  // set by tools/gaitslam
  typed_command = program = files::shell_word(launcher ? launcher : argv[0]);
  for (int i = 1; i < argc; ++i) typed_command += " " + files::shell_word(argv[i]);
}

const std::string& typed_program() { return program; }

OnInterrupt::OnInterrupt(const std::string& kept) {
  own_bytes = 0;
  add(fmt::format("{}gaitslam: interrupted: {}:\n  {}\n", isatty(STDERR_FILENO) == 1 ? "\n" : "", kept,
                  typed_command));
  own_bytes = std::size_t(text_bytes);
  exchange_handlers(SIG_DFL, print_and_end);
}

OnInterrupt::~OnInterrupt() { exchange_handlers(print_and_end, SIG_DFL); }

void OnInterrupt::add(const std::string& text) {
  const std::size_t bytes = std::min(text.size(), text_at_interrupt.size() - own_bytes);
  text_bytes = static_cast<sig_atomic_t>(own_bytes);  // a signal meanwhile prints only what was there before
  std::copy_n(text.begin(), bytes, text_at_interrupt.begin() + std::ptrdiff_t(own_bytes));
  text_bytes = static_cast<sig_atomic_t>(own_bytes + bytes);
}

BlockedInterrupts::BlockedInterrupts() {
  ::sigemptyset(&signals_);
  for (const int one : {SIGINT, SIGTERM, SIGHUP}) ::sigaddset(&signals_, one);
  ::pthread_sigmask(SIG_BLOCK, &signals_, &before_);
}

BlockedInterrupts::~BlockedInterrupts() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

void BlockedInterrupts::wait() const {
  int which = 0;
  ::sigwait(&signals_, &which);
}

bool BlockedInterrupts::pending() const {
  const timespec none{};
  return ::sigtimedwait(&signals_, nullptr, &none) > 0;
}

}  // namespace cli
