#include "tools/cli/out_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iostream>

#include "sim/result/score_table.h"
#include "tools/cli/usage_error.h"

namespace cli {
namespace {

fs::path nearest_existing(const fs::path& folder) {
  std::error_code fault;
  fs::path nearest = fs::absolute(folder);
  while (!fs::exists(nearest, fault) && nearest != nearest.parent_path()) nearest = nearest.parent_path();
  return nearest;
}

void require_folder(const fs::path& path) {
  if (path.empty()) throw UsageError("--out: is empty, expected a folder for results");
  std::error_code fault;
  if (fs::exists(path, fault) && !fs::is_directory(path, fault))
    throw UsageError(fmt::format("{}: is a file, expected a folder for results", path.string()));
}

void require_empty(const fs::path& folder) {
  std::error_code fault;
  if (fs::exists(folder, fault) && !fs::is_empty(folder, fault))
    throw UsageError(
        fmt::format("{}: exists already; --force replaces what the command writes there", folder.string()));
}

/// 0, or the errno for which nothing can be made in the folder.
int why_not_writable(const fs::path& folder) {
  std::error_code fault;
  if (!fs::is_directory(folder, fault)) return ENOTDIR;
  return access(folder.c_str(), W_OK | X_OK) == 0 ? 0 : errno;
}

}  // namespace

void add_out(CLI::App& command, OutRequest& request) {
  command.add_option("--out", request.out, "folder for the results");
  command.add_flag("--force", request.force, "write into a folder that exists, replacing earlier results");
}

OutFolder::OutFolder(const OutRequest& request, const fs::path& standard, bool continues)
    : path_(request.out ? fs::path(*request.out) : standard) {
  require_folder(path_);
  if (request.out && !request.force && !continues) require_empty(path_);
  existing_ = nearest_existing(path_);
  if (const int why = why_not_writable(existing_); why != 0)
    throw UsageError(
        fmt::format("{}: cannot be written: {}: {}", path_.string(), existing_.string(), std::strerror(why)));
}

OutFolder::~OutFolder() {
  std::error_code fault;
  for (fs::path empty = fs::absolute(path_); empty != existing_ && empty != empty.parent_path();
       empty = empty.parent_path()) {
    if (fs::exists(empty, fault) && !fs::remove(empty, fault)) return;
  }
}

int report(const sim::result::Outcome& outcome, const fs::path& result_folder) {
  std::cout << sim::result::score_table(result_folder) << "results in " << result_folder.string() << '\n';
  if (outcome.exit_code == 3) std::cerr << fmt::format("gaitslam: {}: {}\n", outcome.ending, outcome.cause);
  return outcome.exit_code;
}

}  // namespace cli
