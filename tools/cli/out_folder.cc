#include "tools/cli/out_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "tools/cli/commands.h"

namespace cli {

namespace fs = std::filesystem;

void check_out_folder(const fs::path& folder, bool asked_for, bool force) {
  if (folder.empty()) throw UsageError("--out: is empty, expected a folder for results");
  std::error_code fault;
  if (fs::exists(folder, fault) && !fs::is_directory(folder, fault)) {
    throw UsageError(fmt::format("{}: is a file, expected a folder for results", folder.string()));
  }
  if (asked_for && !force && fs::exists(folder, fault) && !fs::is_empty(folder, fault)) {
    throw UsageError(
        fmt::format("{}: exists already; --force replaces what a run writes there", folder.string()));
  }
  fs::path nearest = fs::absolute(folder);
  while (!fs::exists(nearest, fault) && nearest != nearest.parent_path()) nearest = nearest.parent_path();
  const int why = !fs::is_directory(nearest, fault)           ? ENOTDIR
                  : access(nearest.c_str(), W_OK | X_OK) != 0 ? errno
                                                              : 0;
  if (why == 0) return;
  throw UsageError(
      fmt::format("{}: cannot be written: {}: {}", folder.string(), nearest.string(), std::strerror(why)));
}

}  // namespace cli
