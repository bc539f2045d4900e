// Verdicts as text: a table for the terminal, and JUnit XML, Markdown, JSON and GitHub annotations for
// continuous integration.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/regression/verdict.h"

namespace sim::regression {

/// A comparison for printing. file: of a scenario; repro: the command that repeats the run of one seed, or an
/// empty text.
struct Comparison {
  std::string title;
  std::vector<ScenarioVerdict> scenarios;
  std::function<std::string(const std::string& scenario)> file;
  std::function<std::string(const std::string& scenario, std::uint64_t seed)> repro;
};

/// A table of 80 columns. It prints the command that repeats a run once for all its rows. colors: paint the
/// verdicts for a terminal.
std::string verdict_table(const Comparison& comparison, bool colors);
/// JUnit XML with a testcase for each row: a failure for FAIL, MISSING and missed limits, an error for runs
/// that failed, skipped for NEW. The first row of a scenario has the wall time of its runs.
std::string junit(const Comparison& comparison);
/// Markdown tables for a pull request.
std::string markdown(const Comparison& comparison);
/// A line `::error file=...,title=...::...` for each row that fails.
std::string github_annotations(const Comparison& comparison);
/// All verdicts with their numbers.
std::string verdicts_json(const Comparison& comparison);

}  // namespace sim::regression
