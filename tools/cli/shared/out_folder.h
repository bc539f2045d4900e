// The folder that results are written to, and whether they can be.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "sim/result/job_log.h"
#include "sim/result/result.h"
#include "tools/cli/shared/terminal.h"

namespace cli {

/// The options --out and --force.
struct OutRequest {
  std::optional<std::string> out;
  bool force = false;
};
void add_out(CLI::App& command, OutRequest& request);

/// How a command uses its folder.
struct OutUse {
  /// Replaces the folder as a whole; else adds results to it.
  bool replaces = false;
  /// Fixed names of files and folders that it writes into the folder.
  std::vector<std::string> names{};
  /// Folders in it that are replaced one by one, as paths within it.
  std::vector<std::string> results{};
  /// Adds to an existing folder without --force; none of `results` may exist.
  bool continues = false;
  /// Identifies a command that can be resumed, without --force, after an interruption; else absent.
  std::optional<std::string> identity{};
};

/// Throws UsageError if replacing the folder `out` would remove `read`, which the command reads.
void require_separate(const fs::path& out, const fs::path& read);
/// Throws UsageError if a file's folder is missing; the message names the option.
void require_folder_of(const fs::path& file, const std::string& option);
/// Throws UsageError if it is a folder, has no folder, or exists without force; FileError if not regular.
void require_new_file(const fs::path& file, bool force, const std::string& option = "--out");

/// The folder that was asked for, or a standard one, locked by commands that write fixed names there. At the
/// end of its life it removes the marker and the empty folders that it made for nothing.
class OutFolder {
 public:
  /// Recovers what killed processes left, and sets aside the fixed names of an earlier command, unless it is
  /// resumed or continued. Throws UsageError if the folder cannot be written, is locked by another process,
  /// is the current folder and would be replaced, or is not empty and --force is not given; FileError if
  /// anything would be replaced in a folder that the program did not make.
  OutFolder(const OutRequest& request, const fs::path& standard, const OutUse& use = {});
  ~OutFolder();
  OutFolder(const OutFolder&) = delete;
  OutFolder& operator=(const OutFolder&) = delete;

  const fs::path& path() const { return path_; }
  /// Returns finished results of a command with an identity, by their paths in the folder; else nullptr.
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

/// Prints the document of --json (schemas/outcome.schema.json): exit code, folder and details.
void print_outcome(int exit_code, const fs::path& folder, const nlohmann::ordered_json& details);

/// Prints a result folder's score in the chosen format and the cause of a failure; returns the exit code.
/// Also renews the summary.json of the results beside it.
int report(const result::Outcome& outcome, const fs::path& result_folder, bool all_metrics = false);

}  // namespace cli
