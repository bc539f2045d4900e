// The files that verdicts of a comparison are written to, in the formats of other tools.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>

#include "sim/regression/report.h"

namespace cli {

/// What --junit, --markdown and --json ask for. `--json` without a file prints on standard output.
struct VerdictFiles {
  std::optional<std::filesystem::path> junit, markdown, json;

  /// Throws UsageError for a file that exists and does not begin as what would replace it, as one of an
  /// earlier call does: it is somebody else's. To be called before the work of which the verdicts tell.
  void require_replaceable() const;
  /// Throws sim::files::FileError.
  void write(const sim::regression::Comparison& comparison) const;
};

/// Prints the verdicts as a table or as JSON, in the way that was asked for, and writes the files.
void report_verdicts(const sim::regression::Comparison& comparison, const VerdictFiles& files);
/// --junit, --markdown, --json and --quiet.
void add_verdict_files(CLI::App& command, VerdictFiles& files);

}  // namespace cli
