// Fig. 3 of the paper: how the depth hypotheses of a new landmark collapse to a peak.
#pragma once

#include <filesystem>

#include "sim/pages/figure.h"

namespace sim::pages {

/// Of the landmarks in a depths.csv whose depth became known (standard deviation below 0.3 of it), the one
/// that took most images: its hypotheses after the first image, after thirds of them and after the last.
/// Without lines when there is none. Throws files::FileError when the file is broken.
Figure depths_figure(const std::filesystem::path& depths_csv);

}  // namespace sim::pages
