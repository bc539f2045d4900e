#include "tools/cli/jobs/backend.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "tools/cli/usage_error.h"

namespace cli {

void require_usable(const Backend& backend, const std::string& folder) {
  if (!backend.slurm() || folder.find_first_of("\n\r") == folder.npos) return;
  std::string shown = folder;
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c == '\n' || c == '\r'; }, '?');
  throw UsageError(
      fmt::format("--out '{}': has a line break, which command lines of Slurm cannot have", shown));
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

}  // namespace cli
