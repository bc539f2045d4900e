// The folder that results are written to, and checks whether it can be used.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "sim/files/atomic_file.h"
#include "sim/result/result.h"
#include "tools/cli/shared/terminal.h"

namespace cli {

struct OutRequest {
  std::optional<std::string> out;
  bool force = false;
};
void add_out(CLI::App& command, OutRequest& request);

/// Throws UsageError if replacing the folder `out` would remove `read`, an input of the command.
void require_separate(const fs::path& out, const fs::path& read);
/// Throws UsageError if the file's folder does not exist; the message names the option.
void require_folder_of(const fs::path& file, const std::string& option);
/// Throws UsageError if `file` is a folder, its folder does not exist, or it exists and `force` is false;
/// FileError if it is not a regular file.
void require_new_file(const fs::path& file, bool force, const std::string& option = "--out");
/// Throws UsageError if a result folder exists and `force` is false, FileError if the program did not make
/// it.
void require_new_result(const fs::path& folder, bool force);

/// How a command uses its folder: as one result, or to add one result, or to add several while no other
/// command writes there.
enum class OutUse { result, adds_result, adds_results };

/// The requested folder or a standard one. The destructor removes the marker and any empty folders that
/// were not needed.
class OutFolder {
 public:
  /// Creates and marks a folder that results are added to. Throws UsageError or FileError if it cannot be
  /// written, another process adds results, the program did not make it, or it is a result. For a result,
  /// throws as require_new_result() does, and if the folder contains the current folder.
  OutFolder(const OutRequest& request, const fs::path& standard, OutUse use);
  ~OutFolder();
  OutFolder(const OutFolder&) = delete;
  OutFolder& operator=(const OutFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_, existing_;
  std::optional<files::FileLock> lock_;
  OnInterrupt on_interrupt_;
};

/// Prints the --json document (schemas/outcome.schema.json): exit code, folder and details.
void print_outcome(int exit_code, const fs::path& folder, const nlohmann::ordered_json& details);

/// Prints a result folder's score in the chosen format, and the cause if it failed; returns the exit code.
/// Also updates the summary.json of neighboring results.
int report(const result::Outcome& outcome, const fs::path& result_folder, bool all_metrics = false);

}  // namespace cli
