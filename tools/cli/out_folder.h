// The folder that results are written to, and whether they can be.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "sim/result/result.h"

namespace cli {

namespace fs = std::filesystem;

/// The options --out and --force.
struct OutRequest {
  std::optional<std::string> out;
  bool force = false;
};
void add_out(CLI::App& command, OutRequest& request);

/// The folder that was asked for, or a standard one. At the end of its life it removes those folders above
/// the results that did not exist before and are empty.
class OutFolder {
 public:
  /// Creates nothing. Throws UsageError when nothing can be written below the folder (which need not exist
  /// yet), or when --out names a folder that is not empty and --force is not given. continues: a folder that
  /// an earlier command has begun is accepted.
  OutFolder(const OutRequest& request, const fs::path& standard, bool continues = false);
  ~OutFolder();
  OutFolder(const OutFolder&) = delete;
  OutFolder& operator=(const OutFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_, existing_;
};

/// Prints the score of a result folder, and what went wrong; returns the exit code.
int report(const sim::result::Outcome& outcome, const fs::path& result_folder);

}  // namespace cli
