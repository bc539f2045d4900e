// Pictures of a recording for a page: frames along the walk with what the filter looked for in them, as SVG
// that a page holds in itself.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/pages/run_data.h"

namespace sim::pages {

/// svg: the image with, as searches.csv has them, the 3-sigma ellipses that were searched (class "used" where
/// the match entered the update, else "missed") and the 11 x 11 patches that were found. t: s.
struct Picture {
  double t = 0;
  std::string svg;
};

/// `count` frames evenly over the walk; empty if there is no recording with pictures.
std::vector<Picture> pictures(const RunData& run, int count);

/// RFC 4648.
std::string base64(std::string_view bytes);

}  // namespace sim::pages
