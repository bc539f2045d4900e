// Runs a suite: all its scenarios on all its seeds. The output of verdicts.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/regression/report.h"
#include "sim/regression/suite.h"
#include "sim/regression/verdict.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/options.h"

namespace cli {

/// The options of all commands on suites.
struct SuiteRequest : OutRequest {
  std::filesystem::path suite = "scenarios/suites/ci.yaml";
  std::vector<std::string> overrides;
  std::optional<std::string> seeds, baseline;
  std::optional<std::filesystem::path> results;  ///< <scenario>/seed-<n> to judge instead of running
  std::filesystem::path models = standard_models();
  Backend backend;
  bool cached = false;
};

void add_suite_options(CLI::App& command, SuiteRequest& request);

/// The file of the baseline: --baseline, else <suite>.json in baselines/ beside the folder of the suite.
std::filesystem::path baseline_file(const SuiteRequest& request);

/// One scenario of a suite and the results of its runs.
struct SuiteScenario {
  sim::regression::SuiteEntry entry;
  sim::scenario::ReadScenario read;
  std::map<std::string, std::string> file_config;  ///< without the overrides of the command line
  sim::regression::ScenarioResults results;
};

struct SuiteRun {
  std::string name;
  std::vector<std::uint64_t> seeds;
  std::vector<SuiteScenario> scenarios;
};

/// Reads the suite and its scenarios. Throws ConfigError, UsageError.
SuiteRun plan_suite(const SuiteRequest& request);

/// Runs the suite, or reads its results, into run.scenarios[i].results.
void run_suite(const SuiteRequest& request, SuiteRun& run);

/// Results of a scenario and what they are judged by.
struct Judged {
  const sim::regression::ScenarioResults& results;
  const sim::scenario::Scenario& scenario;  ///< with its limits
  const std::vector<sim::regression::Gate>& gates;
  bool expects_missed = false;  ///< see judge_limits()
};
/// Compares results with those of the same name in a baseline and judges limits. A scenario that only one of
/// them has is NEW or MISSING.
std::vector<sim::regression::ScenarioVerdict> verdicts_of(
    const std::vector<sim::regression::ScenarioResults>& baseline, const std::vector<Judged>& now,
    const std::vector<sim::regression::Gate>& gates_of_missing);

/// The verdicts of a suite, with a command that repeats each of its runs.
sim::regression::Comparison compare_with(const std::vector<sim::regression::ScenarioResults>& baseline,
                                         const SuiteRun& run, const SuiteRequest& request,
                                         const std::string& title);

/// The files of --junit, --markdown and --json. `--json` without a file prints on standard output.
using VerdictFiles = std::array<std::optional<std::filesystem::path>, 3>;
/// Also adds --quiet.
void add_verdict_files(CLI::App& command, VerdictFiles& files);
/// Throws UsageError for an existing file that gaitslam did not write: its first bytes differ from those of
/// its replacement. To be called before the comparison.
void require_replaceable(const VerdictFiles& files);
/// Prints the verdicts as a table or as JSON, and writes the files. Throws FileError.
void report_verdicts(const sim::regression::Comparison& comparison, const VerdictFiles& files);

}  // namespace cli
