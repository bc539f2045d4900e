// The paper's experiments: what it reports of each, and what the bench's runs of it say.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/report/figure.h"
#include "sim/report/run_data.h"

namespace sim::report {

/// Runs by experiment's name, as paper_experiments() has it.
using PaperRuns = std::map<std::string, std::vector<RunData>>;

/// One experiment: a scenario walked, or the filter of a scenario on the recordings of another experiment's
/// walks. The scenario's file is <name>.yaml.
struct PaperExperiment {
  std::string name;
  std::string recordings;  ///< experiment whose recordings are replayed; empty: it walks itself
  double cost_s;           ///< CPU of a seed, about: for the time that is left
};

/// In an order in which recordings are there before they are replayed.
const std::vector<PaperExperiment>& paper_experiments();

/// How a row came out. A row of which nothing was run has none.
enum class Agreement { none, agrees, better, differs };

/// A line of the table: what the paper says (with its section), and what came out here.
struct PaperRow {
  std::string what, paper, bench;
  Agreement agreement = Agreement::none;
};

/// The table, row by row; an experiment that is missing says so.
std::vector<PaperRow> paper_rows(const PaperRuns& runs);

/// The paper's figures 1, 3, 4, 6, 7 and 8 remade, each from the first seed that shows it. Throws
/// stream::FileError when a table that a run left is broken.
std::vector<Figure> paper_figures(const PaperRuns& runs);

/// The whole page: a table and pictures, nothing that runs.
std::string paper_page(const PaperRuns& runs, const std::string& revision);

/// "agrees", "better", "differs", or nothing.
std::string agreement_text(Agreement agreement);

}  // namespace sim::report
