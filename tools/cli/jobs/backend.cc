#include "tools/cli/jobs/backend.h"

#include <CLI/CLI.hpp>

namespace cli {

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
