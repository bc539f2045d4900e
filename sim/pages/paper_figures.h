// The figures of the paper, drawn from the runs of this bench.
#pragma once

#include <vector>

#include "sim/pages/figure.h"
#include "sim/pages/paper.h"

namespace sim::pages {

/// Figures 1, 3, 4, 6, 7 and 8 of the paper, each from the first seed that shows it. Throws files::FileError
/// when a table that a run left is broken.
std::vector<Figure> paper_figures(const PaperRuns& runs);

}  // namespace sim::pages
