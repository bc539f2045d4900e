// Several processes of this very program, a few at a time: one that crashes takes no other with it.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace cli {

/// A folder of its own, gone when this is.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// How a process ended.
struct Ended {
  int exit_code = 0;      ///< 3 when a signal killed it
  std::string complaint;  ///< what it wrote to stderr, and the signal that killed it
};

/// Called by a process that was told its parent's id by --die-with-parent: it does not outlive its parent,
/// not even one that has ended by now.
void die_with(pid_t parent);

/// Command lines of this program, without its name. Each takes --die-with-parent.
using CommandLines = std::vector<std::vector<std::string>>;

/// Told now and then how much is done, 0 to 1: by processes that have ended.
using ShowPart = std::function<void(double)>;

/// Runs this program (even when its file has been replaced since) with each of these command lines, `jobs` at
/// a time. In the order of the command lines, whatever the order in which they end.
std::vector<Ended> run_processes(const CommandLines& command_lines, int jobs, const ShowPart& show);

}  // namespace cli
