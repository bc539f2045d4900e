// Verdicts for continuous integration: JUnit XML, Markdown, JSON, and annotations of GitHub's log.
#pragma once

#include <string>

#include "sim/bench/verdict_table.h"

namespace sim::bench {

/// A testcase for each row: failure for FAIL, MISSING and missed limits, error for runs that failed, skipped
/// for NEW.
std::string junit(const Comparison& comparison);
/// A table for pull requests.
std::string markdown(const Comparison& comparison);
/// `::error file=...,title=...::...` for each row that fails.
std::string github_annotations(const Comparison& comparison);
/// Everything of the verdicts.
std::string verdicts_json(const Comparison& comparison);

}  // namespace sim::bench
