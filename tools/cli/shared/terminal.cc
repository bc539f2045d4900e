#include "tools/cli/shared/terminal.h"

#include <unistd.h>

#include <cstdlib>
#include <iostream>

namespace cli {
namespace {

Output chosen = Output::text;

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

}  // namespace cli
