// The files for the verdicts of a comparison, in the formats of other tools.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>

#include "sim/regression/report.h"

namespace cli {

/// The files of --junit, --markdown and --json. `--json` without a file prints on standard output.
struct VerdictFiles {
  std::optional<std::filesystem::path> junit, markdown, json;

  /// Throws UsageError for an existing file that gaitslam did not write: its first bytes differ from those of
  /// its replacement. To be called before the comparison.
  void require_replaceable() const;
  /// Throws sim::files::FileError.
  void write(const sim::regression::Comparison& comparison) const;
};

/// Prints the verdicts as a table or as JSON, and writes the files.
void report_verdicts(const sim::regression::Comparison& comparison, const VerdictFiles& files);
/// --junit, --markdown, --json and --quiet.
void add_verdict_files(CLI::App& command, VerdictFiles& files);

}  // namespace cli
