// Where the processes of a command run: on this machine, or as a job array of a Slurm cluster.
#pragma once

#include <filesystem>
#include <string>

namespace CLI {
class App;
}

namespace cli {

struct Backend {
  std::string name = "local";
  int jobs = 0;  ///< processes or array elements at a time; 0: one here, as many as the cluster has there
  /// Slurm: a folder that all nodes see. What an interrupted command left there is continued.
  std::filesystem::path spool{};
  double seconds_each = 30;  ///< Slurm: about the least time that a command line takes

  bool slurm() const { return name == "slurm"; }
};

/// Throws UsageError where the backend is Slurm and its command lines could not name the folder: each is one
/// line of a file. To be called before anything is made.
void require_usable(const Backend& backend, const std::string& folder);

/// The options --jobs and --backend.
void add_backend_options(CLI::App& command, Backend& backend);

}  // namespace cli
