// The output that was chosen (text, quiet, JSON), and colors.
#pragma once

#include <CLI/CLI.hpp>
#include <iosfwd>

namespace cli {

/// text: for people. quiet: nothing but errors, on standard error. json: one JSON document and nothing else.
enum class Output { text, quiet, json };

Output output();
void choose_output(Output output);

/// The stream of text for people: standard output, or none with --quiet or --json.
std::ostream& text_out();

/// The option --quiet, and --json as a flag.
void add_quiet(CLI::App& command);
void add_output(CLI::App& command);

/// True if a stream (STDOUT_FILENO, STDERR_FILENO) is a terminal that can redraw lines.
bool can_redraw(int stream);
/// True if standard output is a terminal with colors and NO_COLOR is not set.
bool colours();

}  // namespace cli
