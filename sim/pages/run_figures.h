// The figures of one run, and of several runs, which are never pooled over scenarios or estimators.
#pragma once

#include <vector>

#include "sim/pages/figure.h"
#include "sim/pages/run_data.h"

namespace sim::pages {

/// Planned, true and estimated path of the camera, from above.
Figure camera_from_above(const RunData& run);
/// Planned and true path of the waist, from above.
Figure waist_from_above(const RunData& run);
/// Planned, true and estimated height of the camera.
Figure camera_height(const RunData& run);

/// All figures that the run has data for.
std::vector<Figure> run_figures(const RunData& run);

/// Figures for one scenario and estimator: paths of all runs, position error over time (median, minimum and
/// maximum), and mean NEES with its band. Otherwise for each scenario with several runs: paths, error over
/// time, and, of several seeds, ATE and CPU time as boxes and dots of each estimator. Empty for fewer than
/// two runs.
std::vector<Figure> comparison_figures(const std::vector<RunData>& runs);

}  // namespace sim::pages
