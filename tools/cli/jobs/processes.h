// Processes of this program, a few at a time: the crash of one does not affect the others.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/files/atomic_file.h"

namespace cli {

/// A new temporary folder, removed at the end of its life. Those of processes that were killed are removed by
/// the next one on the same machine, which knows them by the lock that nobody holds any more.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
  std::optional<sim::files::FileLock> lock_;
};

/// How a process ended.
struct Ended {
  int exit_code = 0;      ///< 3 when a signal killed it
  std::string complaint;  ///< what it wrote to standard error, and the signal that killed it
};

/// Makes the kernel kill this process when its parent ends, at once if the parent has ended already. For a
/// process that was given its parent's id by --die-with-parent.
void die_with(pid_t parent);

/// Command lines of this program, without its name. Their commands accept --die-with-parent.
using CommandLines = std::vector<std::vector<std::string>>;

/// Called now and then with the part of the work that is done, 0 to 1: processes that have ended count whole,
/// those that run as far as they are.
using ShowPart = std::function<void(double)>;

/// Called when one of the processes has ended, with its number among the command lines.
using OnEnded = std::function<void(std::size_t)>;

/// Runs this program (the running one, even when its file has been replaced) with each of the command lines,
/// `jobs` at a time. Returns how they ended, in the order of the command lines.
std::vector<Ended> run_processes(const CommandLines& command_lines, int jobs, const ShowPart& show,
                                 const OnEnded& on_ended = {});

}  // namespace cli
