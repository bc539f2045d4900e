// The experiments of the paper, the runs of this bench that repeat them, and the page that compares both.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/pages/figure.h"
#include "sim/pages/run_data.h"

namespace sim::pages {

/// One experiment: walks of a scenario, or the filter of a scenario on the recordings of another experiment.
/// The file of the scenario is <name>.yaml.
struct PaperExperiment {
  std::string name;
  std::string recordings;  ///< experiment that it replays; empty: it simulates its walks
  double cost_s;           ///< approximate CPU time of a seed, for the estimate of the time left
};

/// All experiments, ordered so that recordings exist before they are replayed.
const std::vector<PaperExperiment>& paper_experiments();

/// Runs by the name of their experiment.
using PaperRuns = std::map<std::string, std::vector<RunData>>;
/// The runs of an experiment; empty if there are none.
const std::vector<RunData>& runs_of(const PaperRuns& all, const std::string& experiment);

/// A row of the table: what is compared (with the section of the paper), and both results. agreement:
/// "agrees", "better", "differs", or empty if it cannot be compared.
struct PaperRow {
  std::string what, paper, bench = "not run", agreement = "";
};
/// All rows; the result of an experiment without runs is "not run".
std::vector<PaperRow> paper_rows(const PaperRuns& runs);

/// Figure 3, from a depths.csv: the depth hypotheses of the landmark that took most images until its depth
/// was known (standard deviation below 0.3 of it), after the first image, thirds of them and the last.
/// Without lines if there is none.
Figure depths_figure(const std::filesystem::path& depths_csv);

/// The page: table and figures. Throws FileError if a table of a run is broken.
std::string paper_page(const PaperRuns& runs, const std::string& revision);

}  // namespace sim::pages
