// The paper's experiments: what it reports of each, and what the bench's runs of it say.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sim/report/figure.h"
#include "sim/report/run_data.h"

namespace sim::report {

/// Runs by experiment's name, as paper_experiments() has it.
using PaperRuns = std::map<std::string, std::vector<RunData>>;

/// One experiment: a scenario walked, or the filter of a scenario on the recordings of another experiment's
/// walks.
struct PaperExperiment {
  std::string name, scenario;  ///< scenario: file below scenarios/
  std::string recordings;      ///< experiment whose recordings are replayed; empty: it walks itself
};

/// In an order in which recordings are there before they are replayed.
const std::vector<PaperExperiment>& paper_experiments();

/// A line of the table: what the paper says (with its section), and what came out here.
struct PaperRow {
  std::string what, paper, bench;
  std::string verdict;  ///< "agrees", "better", "differs"; empty where there is nothing to compare
};

/// The table, row by row; an experiment that is missing says so.
std::vector<PaperRow> paper_rows(const PaperRuns& runs);

/// The paper's figures 1, 4, 6, 7 and 8 remade from the first seed of their experiments.
std::vector<Figure> paper_figures(const PaperRuns& runs);

/// The whole page: a table and pictures, nothing that runs.
std::string paper_page(const PaperRuns& runs, const std::string& revision);

}  // namespace sim::report
