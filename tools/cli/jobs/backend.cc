#include "tools/cli/jobs/backend.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>

#include "tools/cli/shared/usage_error.h"

namespace cli {

namespace fs = std::filesystem;

void require_usable(const Backend& backend, const std::string& folder) {
  if (!backend.slurm() || folder.find_first_of("\n\r") == folder.npos) return;
  std::string shown = folder;
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c == '\n' || c == '\r'; }, '?');
  throw UsageError(fmt::format("--out '{}': has a line break, which Slurm command lines cannot have", shown));
}

void add_backend_options(CLI::App& command, Backend& backend) {
  command
      .add_option("--jobs", backend.jobs,
                  "number of processes at a time (default 1); on Slurm, of array elements (default all)")
      ->check(CLI::Range(1, 100000));
  command
      .add_option("--backend", backend.name,
                  "local runs processes on this machine, slurm a job array on the cluster")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str();
}

std::vector<Ended> run_all(const CommandLines& command_lines, const Backend& backend, const ShowPart& show,
                           const OnEnded& on_ended) {
  if (command_lines.empty()) return {};
  return backend.slurm() ? run_on_slurm(command_lines, backend, show)
                         : run_processes(command_lines, std::max(backend.jobs, 1), show, on_ended);
}

SharedFolder::SharedFolder(const Backend& backend) {
  if (!backend.slurm()) {
    temporary_.emplace();
    return;
  }
  folder_ = backend.spool;
  fs::create_directories(folder_);
}

SharedFolder::~SharedFolder() {
  if (!folder_.empty() && std::uncaught_exceptions() > 0) return;  // a job that may still run reads them
  std::error_code ignored;
  for (const fs::path& file : files_) fs::remove(file, ignored);
  if (!folder_.empty()) fs::remove(folder_, ignored);  // only if it is empty
}

fs::path SharedFolder::operator/(const std::string& name) {
  if (temporary_) return *temporary_ / name;
  files_.push_back(folder_ / name);
  return files_.back();
}

}  // namespace cli
