// The page of a report: one HTML file that needs no other file.
#pragma once

#include <string>
#include <vector>

#include "sim/pages/run_data.h"

namespace sim::pages {

/// The whole page about these runs (one at least). Throws files::FileError when a file of a run is broken.
std::string page(const std::vector<RunData>& runs);

}  // namespace sim::pages
