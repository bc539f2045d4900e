#include "tools/cli/jobs/shell.h"

#include <array>
#include <cstdio>
#include <string_view>

#include "tools/cli/usage_error.h"

namespace cli {

std::string shell_word(const std::string& text) {
  static constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+=./,:@%";
  if (!text.empty() && text.find_first_not_of(kPlain) == text.npos) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

ShellOutput run_shell(const std::string& command) {
  FILE* const pipe = ::popen((command + " 2>&1").c_str(), "r");
  if (!pipe) throw UsageError(command + ": cannot be started");
  ShellOutput printed;
  std::array<char, 4096> piece;
  for (std::size_t n = 0; (n = std::fread(piece.data(), 1, piece.size(), pipe)) > 0;)
    printed.text.append(piece.data(), n);
  printed.status = ::pclose(pipe);
  return printed;
}

}  // namespace cli
