#include "tools/cli/jobs/terminal.h"

#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <string_view>

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

void add_quiet(CLI::App& command) {
  command.add_flag_callback(
      "-q,--quiet", [] { choose_output(Output::quiet); },
      "print nothing but errors; the exit code says the rest");
}

void add_output(CLI::App& command) {
  add_quiet(command);
  command
      .add_flag_callback(
          "--json", [] { choose_output(Output::json); },
          "print one JSON document and nothing else (schemas/outcome.schema.json)")
      ->excludes("--quiet");
}

bool can_redraw(int stream) {
  const char* const kind = std::getenv("TERM");
  return isatty(stream) == 1 && kind && std::string_view(kind) != "dumb";
}

bool colours() {
  const char* const unwanted = std::getenv("NO_COLOR");
  return can_redraw(STDOUT_FILENO) && (!unwanted || *unwanted == '\0');
}

}  // namespace cli
