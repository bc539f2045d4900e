// Figures of several runs: of one set of results, or of several scenarios and estimators, which are never
// pooled.
#pragma once

#include <vector>

#include "sim/pages/figure.h"
#include "sim/pages/run_data.h"

namespace sim::pages {

/// For runs of one scenario and estimator batch_figures(). Otherwise for each scenario with several runs the
/// paths, the error over time (median over the seeds of each estimator), and, of more than one seed, the ATE
/// and the CPU time as boxes and of every run; a line, or a box, for each estimator.
std::vector<Figure> comparison_figures(const std::vector<RunData>& runs);

}  // namespace sim::pages
