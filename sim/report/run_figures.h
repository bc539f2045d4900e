// The figures of one run, and those of several runs of one scenario together.
#pragma once

#include <vector>

#include "sim/report/figure.h"
#include "sim/report/run_data.h"

namespace sim::report {

/// Those for which the run left something to show.
std::vector<Figure> run_figures(const RunData& run);

/// Position error over time: median, least and greatest over runs that were scored; their mean normalised
/// error squared with its band; and where the walks led.
/// Empty for fewer than two runs.
std::vector<Figure> batch_figures(const std::vector<RunData>& runs);

}  // namespace sim::report
