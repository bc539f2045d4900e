// The page of a tuning: how the search went, what the recordings tell, whether it helps on unseen ones.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/report/figure.h"

namespace sim::report {

/// All figures of a tuning's folder (tune.json, history.csv). Throws stream::FileError where they are broken.
std::vector<Figure> tune_figures(const std::filesystem::path& folder);

/// The page as one HTML file that needs nothing but itself. Throws as tune_figures.
std::string tune_page(const std::filesystem::path& folder);

}  // namespace sim::report
