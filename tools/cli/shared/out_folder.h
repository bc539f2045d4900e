// The folder that results are written to, and checks whether it can be used.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "sim/result/job_log.h"
#include "sim/result/result.h"
#include "tools/cli/shared/terminal.h"

namespace cli {

struct OutRequest {
  std::optional<std::string> out;
  bool force = false;
};
void add_out(CLI::App& command, OutRequest& request);

/// How a command uses its folder.
struct OutUse {
  /// Replaces the whole folder; otherwise adds results to it.
  bool replaces = false;
  /// Names of files and folders that the command always writes to the folder.
  std::vector<std::string> names{};
  /// Folders that are replaced one by one, as paths relative to this one.
  std::vector<std::string> results{};
  /// Adds to an existing folder without --force; none of `results` may exist.
  bool continues = false;
  /// Identifies a command that can be resumed after an interruption without --force; absent for others.
  std::optional<std::string> identity{};
};

/// Throws UsageError if replacing the folder `out` would remove `read`, an input of the command.
void require_separate(const fs::path& out, const fs::path& read);
/// Throws UsageError if the file's folder does not exist; the message names the option.
void require_folder_of(const fs::path& file, const std::string& option);
/// Throws UsageError if `file` is a folder, its folder does not exist, or it exists and `force` is false;
/// FileError if it is not a regular file.
void require_new_file(const fs::path& file, bool force, const std::string& option = "--out");

/// The requested folder or a standard one, locked by commands that write fixed names there. The destructor
/// removes the marker and any empty folders that turned out to be unnecessary.
class OutFolder {
 public:
  /// Cleans up after killed processes and, unless an earlier command is resumed or continued, sets aside its
  /// fixed names. Throws UsageError if the folder is not writable, is locked by another process, is the
  /// current folder and would be replaced, or is not empty and --force is not given. Throws FileError if
  /// anything would be replaced in a folder that the program did not make.
  OutFolder(const OutRequest& request, const fs::path& standard, const OutUse& use = {});
  ~OutFolder();
  OutFolder(const OutFolder&) = delete;
  OutFolder& operator=(const OutFolder&) = delete;

  const fs::path& path() const { return path_; }
  /// Returns the log of finished results, keyed by relative path; nullptr for a command without identity.
  result::JobLog* log() const { return log_ ? &*log_ : nullptr; }
  /// Marks the command as complete.
  void finished() const;

 private:
  fs::path path_, existing_;
  std::vector<std::string> names_;
  std::optional<files::FileLock> lock_;
  bool made_marker_ = false;
  mutable std::optional<result::JobLog> log_;
  OnInterrupt on_interrupt_;
};

/// Prints the --json document (schemas/outcome.schema.json): exit code, folder and details.
void print_outcome(int exit_code, const fs::path& folder, const nlohmann::ordered_json& details);

/// Prints a result folder's score in the chosen format, and the cause if it failed; returns the exit code.
/// Also updates the summary.json of neighboring results.
int report(const result::Outcome& outcome, const fs::path& result_folder, bool all_metrics = false);

}  // namespace cli
