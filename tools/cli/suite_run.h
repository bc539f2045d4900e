// Runs a suite: all its scenarios on all its seeds, live or from recordings.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/bench/suite.h"
#include "sim/bench/verdict.h"
#include "sim/bench/verdict_table.h"
#include "tools/cli/backend.h"

namespace cli {

/// What the command line asks for.
struct SuiteRequest {
  std::filesystem::path suite = "scenarios/suites/ci.yaml";
  std::vector<std::string> overrides;
  std::optional<std::string> seeds, out, baseline;
  std::optional<std::filesystem::path> recordings;  ///< <scenario>/seed-<n> to replay instead of walking
  std::optional<std::filesystem::path> results;     ///< <scenario>/seed-<n> to judge instead of running
  std::filesystem::path models;
  Backend backend;
  bool force = false, cached = false;
};

/// The options that all commands on suites have.
void add_suite_options(CLI::App& command, SuiteRequest& request);

/// The baseline's file: the one asked for, else the suite's namesake in baselines/ beside the suite's folder.
std::filesystem::path baseline_file(const SuiteRequest& request);

/// One scenario of a suite, read, and what came of its runs. file_config: without the command line's
/// overrides.
struct SuiteScenario {
  sim::bench::SuiteEntry entry;
  sim::bench::ReadScenario read;
  std::map<std::string, std::string> file_config;
  sim::bench::ScenarioResults results;
};

struct SuiteRun {
  std::string name;
  std::vector<std::uint64_t> seeds;
  std::vector<SuiteScenario> scenarios;
};

/// Reads suite and scenarios; runs nothing. Throws ConfigError, UsageError.
SuiteRun plan_suite(const SuiteRequest& request);

/// Runs all of it (or reads its results) into run.scenarios[i].results.
void run_suite(const SuiteRequest& request, SuiteRun& run);

/// The run against a baseline's scenarios, with limits. A scenario that one side alone has is NEW or MISSING.
sim::bench::Comparison compare_with(const std::vector<sim::bench::ScenarioResults>& baseline,
                                    const SuiteRun& run, const SuiteRequest& request,
                                    const std::string& title);

/// Quoted for a shell where that is needed.
std::string shell_word(const std::string& text);

/// Standard output is a terminal that may show colours.
bool colours();

}  // namespace cli
