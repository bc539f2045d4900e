// Where the processes of a command run: on this machine, or as a job array of a Slurm cluster.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/cli/processes.h"

namespace CLI {
class App;
}

namespace cli {

struct Backend {
  std::string name = "local";
  int jobs =
      0;  ///< processes, or elements of a job array, at a time; 0: one here, and there what the cluster has
  /// slurm: a folder that all nodes see; what is there of an earlier, interrupted command is taken up.
  std::filesystem::path spool{};
  double seconds_each = 30;  ///< slurm: what a command line takes at least, roughly

  bool slurm() const { return name == "slurm"; }
};

/// The options --jobs and --backend.
void add_backend_options(CLI::App& command, Backend& backend);

/// Runs the command lines where the backend says; in their order, whatever the order in which they end. On
/// Slurm the elements of the array last for half a minute at least, a lost node's are begun again, and the
/// same call after this process was killed takes up where it was. Throws UsageError.
std::vector<Ended> run_all(const CommandLines& command_lines, const Backend& backend, const ShowPart& show);

/// A folder for files that the processes are to read: temporary, or on Slurm the spool, where they stay until
/// this goes.
class SharedFolder {
 public:
  explicit SharedFolder(const Backend& backend);
  ~SharedFolder();
  SharedFolder(const SharedFolder&) = delete;
  SharedFolder& operator=(const SharedFolder&) = delete;
  std::filesystem::path operator/(const std::string& name);

 private:
  std::optional<TemporaryFolder> temporary_;
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> files_;
};

}  // namespace cli
