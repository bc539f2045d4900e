#include "tools/cli/out_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iostream>

#include "tools/cli/commands.h"

namespace cli {
namespace {

fs::path nearest_existing(const fs::path& folder) {
  std::error_code fault;
  fs::path nearest = fs::absolute(folder);
  while (!fs::exists(nearest, fault) && nearest != nearest.parent_path()) nearest = nearest.parent_path();
  return nearest;
}

/// 0, or the errno for which nothing can be made in the folder.
int why_not_writable(const fs::path& folder) {
  std::error_code fault;
  if (!fs::is_directory(folder, fault)) return ENOTDIR;
  return access(folder.c_str(), W_OK | X_OK) == 0 ? 0 : errno;
}

}  // namespace

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
  const fs::path nearest = nearest_existing(folder);
  if (const int why = why_not_writable(nearest); why != 0) {
    throw UsageError(
        fmt::format("{}: cannot be written: {}: {}", folder.string(), nearest.string(), std::strerror(why)));
  }
}

NewFolders::NewFolders(const fs::path& folder)
    : folder_(fs::absolute(folder)), existing_(nearest_existing(folder)) {}

NewFolders::~NewFolders() {
  std::error_code fault;
  for (fs::path empty = folder_; empty != existing_ && empty != empty.parent_path();
       empty = empty.parent_path()) {
    if (fs::exists(empty, fault) && !fs::remove(empty, fault)) return;
  }
}

int report(const bench::Outcome& outcome, const fs::path& result_folder) {
  std::cout << bench::score_table(result_folder) << "results in " << result_folder.string() << '\n';
  if (outcome.exit_code == 3) std::cerr << fmt::format("gaitslam: {}: {}\n", outcome.ending, outcome.cause);
  return outcome.exit_code;
}

}  // namespace cli
