// The page of the reproduced paper.
#pragma once

#include <string>

#include "sim/pages/paper.h"

namespace sim::pages {

/// The whole HTML page: the table and the figures, without a script.
std::string paper_page(const PaperRuns& runs, const std::string& revision);

}  // namespace sim::pages
