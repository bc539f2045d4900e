#include "tools/cli/backend.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "tools/cli/slurm.h"

namespace cli {

namespace fs = std::filesystem;

void add_backend_options(CLI::App& command, Backend& backend) {
  command
      .add_option("--jobs", backend.jobs,
                  "processes at a time (1); on slurm: elements of the job array (all)")
      ->check(CLI::Range(1, 100000));
  command.add_option("--backend", backend.name, "local: processes here; slurm: a job array of the cluster")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str();
}

std::vector<Ended> run_all(const CommandLines& command_lines, const Backend& backend, const ShowPart& show) {
  if (command_lines.empty()) return {};
  return backend.slurm() ? run_on_slurm(command_lines, backend, show)
                         : run_processes(command_lines, std::max(backend.jobs, 1), show);
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
  std::error_code ignored;
  for (const fs::path& file : files_) fs::remove(file, ignored);
  if (!folder_.empty()) fs::remove(folder_, ignored);  // if it is empty now
}

fs::path SharedFolder::operator/(const std::string& name) {
  if (temporary_) return *temporary_ / name;
  files_.push_back(folder_ / name);
  return files_.back();
}

}  // namespace cli
