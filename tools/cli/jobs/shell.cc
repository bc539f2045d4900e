#include "tools/cli/jobs/shell.h"

#include <array>
#include <cstdio>

#include "tools/cli/usage_error.h"

namespace cli {

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
