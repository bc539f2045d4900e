// Runs command lines of this program on the backend that was chosen.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/cli/jobs/backend.h"
#include "tools/cli/jobs/processes.h"

namespace cli {

/// Runs the command lines and returns how they ended, in their order. On Slurm the elements of the array last
/// half a minute at least, those of a lost node are started again, and after this process was killed the same
/// call continues where it stopped; on_ended is not called there. Throws UsageError.
std::vector<Ended> run_all(const CommandLines& command_lines, const Backend& backend, const ShowPart& show,
                           const OnEnded& on_ended = {});

/// A folder for files that the processes read: temporary, or on Slurm the spool, where the files stay for the
/// lifetime of this object.
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
