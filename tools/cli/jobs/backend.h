// Runs command lines of this program: as processes on this machine, or as a job array of a Slurm cluster.
#pragma once

#include <sys/types.h>

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sim/files/atomic_file.h"
#include "sim/scenario/scenario.h"
#include "tools/cli/shared/terminal.h"

namespace cli {

/// A new temporary folder, removed by the destructor. Each also removes those of killed processes here.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
  std::optional<files::FileLock> lock_;
};

/// Makes the kernel kill this process when its parent ends. For a process started with --die-with-parent.
void die_with(pid_t parent);

/// A command line of this program, without its name. Its command accepts --die-with-parent.
struct CommandLine {
  std::vector<std::string> words;
  double cost = 1;  ///< relative to the others, for the progress
};
using CommandLines = std::vector<CommandLine>;

/// How a process ended.
struct Exited {
  int exit_code = 0;      ///< 3 when a signal killed it
  std::string complaint;  ///< its standard error, and the signal that killed it
  int signal = 0;
};

/// Returns the part of the command lines' cost that is done, 0 to 1, from part(i) of each.
double part_of_cost(const CommandLines& lines, const std::function<double(std::size_t)>& part);

/// Called now and then with the part of the work that is done, 0 to 1.
using ShowPart = std::function<void(double)>;
/// Called when one of the processes has ended, with the index of its command line.
using OnEnded = std::function<void(std::size_t)>;

struct Backend {
  std::string name = "local";
  int jobs = 0;  ///< processes or array elements at a time; 0: one here, all that the cluster allows there
  /// Slurm: a folder that all nodes see. What an interrupted command left there is continued.
  fs::path spool{};
  double seconds_each = 30;  ///< Slurm: a lower bound of the time of a command line

  bool slurm() const { return name == "slurm"; }
};

/// Adds the option --backend.
void add_backend(CLI::App& command, std::string& name);
/// Adds the options --jobs and --backend.
void add_backend_options(CLI::App& command, Backend& backend);

/// Throws UsageError if the backend is Slurm and the folder's name has a line break: command lines are lines
/// of a file. Call it before anything is made.
void require_usable(const Backend& backend, const std::string& folder);

/// Runs this program, even if its file was replaced, with each command line; returns how they ended. On Slurm
/// the elements of the array last at least half a minute, those of a lost node are restarted, after a kill
/// the same call resumes, and on_ended is not called. Throws UsageError, and files::DeviceError if one of
/// them ended with kDeviceFailed; then no further ones are started.
std::vector<Exited> run_all(const CommandLines& command_lines, const Backend& backend, const ShowPart& show,
                            const OnEnded& on_ended = {});

/// Runs the command lines on Slurm and returns how they ended, see run_all().
std::vector<Exited> run_on_slurm(const CommandLines& command_lines, const Backend& backend,
                                 const ShowPart& show);

/// Throws UsageError if a job array that an earlier call left in the spool may still run.
void require_ended_arrays(const fs::path& spool);

/// Removes the ended job arrays that an earlier call left in the spool, and the folder if it is then empty.
void remove_arrays(const fs::path& spool);

/// Files that the processes read: each scenario as it is now, so that later edits change no queued job, and
/// the origins of its keys. They exist as long as this object, on Slurm longer after an exception.
class FrozenScenarios {
 public:
  /// In a temporary folder, on Slurm in the spool.
  explicit FrozenScenarios(const Backend& backend);
  ~FrozenScenarios();
  FrozenScenarios(const FrozenScenarios&) = delete;
  FrozenScenarios& operator=(const FrozenScenarios&) = delete;

  /// Returns the words of a command line: the file of that name, and --set-by with the origins.
  std::vector<std::string> words(const std::string& name, const scenario::ReadScenario& read);

 private:
  std::optional<TemporaryFolder> temporary_;
  fs::path folder_;
  std::set<std::string> written_;
};

}  // namespace cli
