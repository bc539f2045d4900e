// The part of a page about one run.
#pragma once

#include <string>
#include <vector>

#include "sim/pages/run_data.h"

namespace sim::pages {

struct Verdict {
  int exit_code = 0;
  std::string text;
};
/// By the limits of the run's own scenario.
Verdict verdict_of(const RunData& run);

/// Frames with images, evenly spaced over the walk, as SVG: the image with the 3-sigma ellipses that were
/// searched (class "used" if the match entered the update, else "missed") and the 11 x 11 patches found.
struct Picture {
  double t = 0;  ///< s
  std::string svg;
};
/// Empty if there is no recording with images.
std::vector<Picture> pictures(const RunData& run, int count);

/// The sections of a run as HTML, with links to them. prefix: of the ids. title: of the first section.
std::string run_sections(const RunData& run, const std::string& prefix, const std::string& title);

}  // namespace sim::pages
