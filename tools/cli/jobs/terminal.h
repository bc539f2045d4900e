// What a command says on standard output, and whether in colours.
#pragma once

#include <CLI/CLI.hpp>
#include <iosfwd>

namespace cli {

/// text: for people. quiet: nothing but errors, on standard error. json: one JSON document and nothing else.
enum class Output { text, quiet, json };

Output output();
void choose_output(Output output);

/// Where text for people goes: standard output, or nowhere where something else was asked for.
std::ostream& text_out();

/// The option --quiet, and --json as a flag.
void add_quiet(CLI::App& command);
void add_output(CLI::App& command);

/// Whether a stream (STDOUT_FILENO, STDERR_FILENO) is a terminal on which lines can be drawn again.
bool can_redraw(int stream);
/// Whether standard output is a terminal that may show colours: not where NO_COLOR is set to anything, nor on
/// a terminal that is dumb.
bool colours();

}  // namespace cli
