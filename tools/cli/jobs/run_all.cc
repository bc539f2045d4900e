#include "tools/cli/jobs/run_all.h"

#include <algorithm>

#include "tools/cli/jobs/slurm.h"

namespace cli {

namespace fs = std::filesystem;

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
