// Text from outside as part of what the program prints: for a terminal, and for a shell.
#pragma once

#include <string>

namespace sim::files {

/// The text without what a terminal obeys: each control character (line feed and tab excepted), each
/// character that turns the direction of writing, and each byte that is no UTF-8 becomes a '?'.
std::string without_controls(const std::string& text);

/// The text as one word of a POSIX shell's command, in quotes where that is needed.
std::string shell_word(const std::string& text);

}  // namespace sim::files
