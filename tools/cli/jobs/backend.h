// Runs command lines of this program: as processes on this machine, or as a job array of a Slurm cluster.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/cli/jobs/processes.h"

namespace CLI {
class App;
}

namespace cli {

struct Backend {
  std::string name = "local";
  int jobs = 0;  ///< processes or array elements at a time; 0: one here, all that the cluster allows there
  /// Slurm: a folder that all nodes see. What an interrupted command left there is continued.
  std::filesystem::path spool{};
  double seconds_each = 30;  ///< Slurm: a lower bound of the time of a command line

  bool slurm() const { return name == "slurm"; }
};

/// The options --jobs and --backend.
void add_backend_options(CLI::App& command, Backend& backend);

/// Throws UsageError if the backend is Slurm and the folder's name has a line break: command lines are lines
/// of a file. Call it before anything is made.
void require_usable(const Backend& backend, const std::string& folder);

/// Runs the command lines and returns how they ended, in their order. On Slurm the elements of the array last
/// at least half a minute, those of a lost node are restarted, and after a kill the same call resumes;
/// on_ended is not called there. Throws UsageError.
std::vector<Ended> run_all(const CommandLines& command_lines, const Backend& backend, const ShowPart& show,
                           const OnEnded& on_ended = {});

/// Runs the command lines on Slurm, see run_all().
std::vector<Ended> run_on_slurm(const CommandLines& command_lines, const Backend& backend,
                                const ShowPart& show);

/// Throws UsageError if a job array that an earlier call left in the spool may still run.
void require_ended_arrays(const std::filesystem::path& spool);

/// Removes the ended job arrays that an earlier call left in the spool, and the folder if nothing else is in
/// it.
void remove_arrays(const std::filesystem::path& spool);

/// A folder for files that the processes read: temporary, or on Slurm the spool. The files exist as long as
/// this object, on Slurm longer if an exception ends the command.
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
