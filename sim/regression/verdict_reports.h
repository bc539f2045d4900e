// Verdicts for continuous integration: JUnit XML, Markdown, JSON, and annotations of GitHub's log.
#pragma once

#include <string>

#include "sim/regression/verdict_table.h"

namespace sim::regression {

/// JUnit XML with a testcase for each row: a failure for FAIL, MISSING and missed limits, an error for runs
/// that failed, skipped for NEW.
std::string junit(const Comparison& comparison);
/// Markdown tables for a pull request.
std::string markdown(const Comparison& comparison);
/// A line `::error file=...,title=...::...` for each row that fails.
std::string github_annotations(const Comparison& comparison);
/// All verdicts with their numbers.
std::string verdicts_json(const Comparison& comparison);

}  // namespace sim::regression
