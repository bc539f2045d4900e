// Runs a suite: all its scenarios on all its seeds.
#pragma once

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

namespace cli {

/// The options of all commands on suites.
struct SuiteRequest : OutRequest {
  std::filesystem::path suite = "scenarios/suites/ci.yaml";
  std::vector<std::string> overrides;
  std::optional<std::string> seeds, baseline;
  std::optional<std::filesystem::path> results;  ///< <scenario>/seed-<n> to judge instead of running
  std::filesystem::path models;
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

/// Compares the run with the scenarios of a baseline and judges limits. A scenario that only one of them has
/// is NEW or MISSING.
sim::regression::Comparison compare_with(const std::vector<sim::regression::ScenarioResults>& baseline,
                                         const SuiteRun& run, const SuiteRequest& request,
                                         const std::string& title);

}  // namespace cli
