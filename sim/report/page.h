// A report's page: one HTML file that needs nothing but itself.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/report/run_data.h"

namespace sim::report {

/// What the browser runs and how it looks, as bundled into the program when it was built.
std::string_view page_script();
std::string_view page_style();

/// The whole page on these runs, of which there is at least one. Throws stream::FileError when something the
/// runs' folders should hold is broken.
std::string page(const std::vector<RunData>& runs);

}  // namespace sim::report
