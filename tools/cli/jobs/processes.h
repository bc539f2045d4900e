// Processes of this program, a few at a time; the crash of one does not affect the others.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/files/atomic_file.h"

namespace cli {

/// A new temporary folder, removed by the destructor. Each also removes those of killed processes on the same
/// machine: their locks are free.
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
  std::string complaint;  ///< its standard error, and the signal that killed it
};

/// Makes the kernel kill this process when its parent ends. For a process started with --die-with-parent.
void die_with(pid_t parent);

/// A command line of this program, without its name. Its command accepts --die-with-parent.
struct CommandLine {
  std::vector<std::string> words;
  double cost = 1;  ///< relative to the others, for the progress
};
using CommandLines = std::vector<CommandLine>;

/// The part of their cost that is done: part(i) of each, 0 to 1.
double part_of_cost(const CommandLines& lines, const std::function<double(std::size_t)>& part);

/// Called now and then with the part of the work that is done, 0 to 1.
using ShowPart = std::function<void(double)>;

/// Called when one of the processes has ended, with the index of its command line.
using OnEnded = std::function<void(std::size_t)>;

/// Runs the running program, even if its file was replaced, with each of the command lines, `jobs` at a time.
/// Returns how they ended, in the order of the command lines.
std::vector<Ended> run_processes(const CommandLines& command_lines, int jobs, const ShowPart& show,
                                 const OnEnded& on_ended = {});

}  // namespace cli
