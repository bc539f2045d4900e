// The table that compares the paper with the runs of this bench.
#pragma once

#include <vector>

#include "sim/pages/paper.h"

namespace sim::pages {

/// All rows; the result of an experiment that was not run is "not run".
std::vector<PaperRow> paper_rows(const PaperRuns& runs);

}  // namespace sim::pages
