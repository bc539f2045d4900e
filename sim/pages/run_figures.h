// The figures of one run, and those of several runs of one scenario together.
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

/// All figures for which the run left data.
std::vector<Figure> run_figures(const RunData& run);

/// The figures, each showing these runs.
std::vector<Figure> of_runs(std::vector<Figure> figures, const std::vector<RunData>& runs);

/// Position error over time (median, minimum and maximum over the runs), mean NEES with its band, and the
/// paths of all runs. Empty for fewer than two runs.
std::vector<Figure> batch_figures(const std::vector<RunData>& runs);

}  // namespace sim::pages
