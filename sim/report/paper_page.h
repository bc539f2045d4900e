// The page of the reproduced paper.
#pragma once

#include <string>

#include "sim/report/paper.h"

namespace sim::report {

/// The whole HTML page: the table and the figures, without a script.
std::string paper_page(const PaperRuns& runs, const std::string& revision);

}  // namespace sim::report
