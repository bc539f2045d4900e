// Verdicts on results, and their output.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/regression/verdict.h"
#include "tools/cli/shared/options.h"

namespace cli {

/// Results of a scenario and what they are judged by.
struct Judged {
  const regression::ScenarioResults& results;
  const scenario::Scenario& scenario;  ///< with its limits
  const std::vector<regression::Gate>& gates;
  std::function<std::string(std::uint64_t seed)> repro;
  std::string file = "";
  bool expects_missed = false;  ///< see judge_limits()
};
/// Compares results with those of the same name in a baseline and judges limits. A scenario that only one of
/// them has is NEW or MISSING.
std::vector<regression::ScenarioVerdict> verdicts_of(const std::vector<regression::ScenarioResults>& baseline,
                                                     const std::vector<Judged>& now,
                                                     const std::vector<regression::Gate>& gates_of_missing);

/// The files of --junit, --markdown and --json. `--json` without a file prints on standard output.
using VerdictFiles = std::array<std::optional<fs::path>, 3>;
/// Also adds --quiet.
void add_verdict_files(CLI::App& command, VerdictFiles& files);
/// Throws UsageError for an existing file that gaitslam did not write: its first bytes differ from those of
/// its replacement. To be called before the comparison.
void require_replaceable(const VerdictFiles& files);
/// Prints the verdicts as a table or as JSON, and writes the files. Throws FileError.
void report_verdicts(const regression::Comparison& comparison, const VerdictFiles& files);

}  // namespace cli
