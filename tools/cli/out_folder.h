// The folder that results are written to, and whether they can be.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sim/files/file_lock.h"
#include "sim/result/result.h"
#include "tools/cli/interruption.h"

namespace cli {

namespace fs = std::filesystem;

/// The options --out and --force.
struct OutRequest {
  std::optional<std::string> out;
  bool force = false;
};
void add_out(CLI::App& command, OutRequest& request);

/// What a command does with its folder.
struct OutUse {
  /// The folder is replaced as a whole; else results are added to it.
  bool replaces = false;
  /// What the command writes into the folder under names of its own; those of folders end in "/".
  std::vector<std::string> names{};
  /// Folders in it that are replaced one by one, as paths within it.
  std::vector<std::string> results{};
  /// It adds to what it finds there, without --force; none of its `results` may be there.
  bool continues = false;
  /// Identifies a command that goes on, without --force, where the same one was interrupted; else empty.
  std::string identity{};
};

/// Throws UsageError where replacing the folder `out` would remove `read`, which the command reads.
void require_outside(const fs::path& out, const fs::path& read);
/// Throws UsageError where the file exists and force is not given, or is a folder; FileError where it is no
/// regular file.
void require_new_file(const fs::path& file, bool force);

/// The folder that was asked for, or a standard one. Commands that write there under names of their own lock
/// it. At the end of its life it gives up those of its names that were not written, and removes those folders
/// above the results that did not exist before and are empty.
class OutFolder {
 public:
  /// Throws UsageError when nothing can be written below the folder (which need not exist yet), when --out
  /// names a folder that is not empty and --force is not given, when the current folder would be replaced, or
  /// when another process writes there;
  /// FileError when anything would be replaced that the program did not make. Leftovers of killed processes
  /// are removed and count for nothing.
  OutFolder(const OutRequest& request, const fs::path& standard, const OutUse& use = {});
  ~OutFolder();
  OutFolder(const OutFolder&) = delete;
  OutFolder& operator=(const OutFolder&) = delete;

  const fs::path& path() const { return path_; }
  /// Whether the interrupted command has noted this as finished.
  bool has_made(const std::string& name) const { return made_.contains(name); }
  /// Notes for the same command, should this one be interrupted, what is finished: a path within the folder.
  void note_made(const std::string& name) const;
  /// The command has done what it was to do.
  void finished() const;

 private:
  void begin(const OutUse& use);
  void drop_names() noexcept;

  fs::path path_, existing_;
  std::vector<std::string> names_;
  std::string identity_;
  bool goes_on_ = false;
  std::set<std::string> made_;  ///< by the interrupted command
  std::optional<sim::files::FileLock> lock_;
  OnInterrupt on_interrupt_;
};

/// Prints the document of --json (schemas/outcome.schema.json); details: what it has besides exit code and
/// folder.
void print_outcome(int exit_code, const fs::path& folder, const nlohmann::ordered_json& details);

/// Prints the score of a result folder, in the way that was asked for, and what went wrong; returns the exit
/// code.
int report(const sim::result::Outcome& outcome, const fs::path& result_folder, bool all_metrics = false);

}  // namespace cli
