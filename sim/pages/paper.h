// The experiments of the paper, and the runs of this bench that repeat them.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/pages/run_data.h"

namespace sim::pages {

/// One experiment: walks of a scenario, or the filter of a scenario on the recordings of another experiment.
/// The file of the scenario is <name>.yaml.
struct PaperExperiment {
  std::string name;
  std::string recordings;  ///< experiment whose recordings are replayed; empty: it simulates its walks
  double cost_s;           ///< approximate CPU time of a seed, for the estimate of the time left
};

/// All experiments, ordered so that recordings exist before they are replayed.
const std::vector<PaperExperiment>& paper_experiments();

/// Runs by the name of their experiment.
using PaperRuns = std::map<std::string, std::vector<RunData>>;
/// The runs of an experiment; empty if there are none.
const std::vector<RunData>& runs_of(const PaperRuns& all, const std::string& experiment);

/// How a row compares with the paper; none: nothing was run.
enum class Agreement { none, agrees, better, differs };
/// "", "agrees", "better" or "differs".
std::string agreement_text(Agreement agreement);

/// A row of the table: what is compared (with the section of the paper), and both results.
struct PaperRow {
  std::string what, paper, bench;
  Agreement agreement = Agreement::none;
};

}  // namespace sim::pages
