// Whether the estimated height changes more after a foot touches the ground, which the paper leaves open.
#pragma once

#include <optional>
#include <vector>

#include "sim/pages/figure.h"
#include "sim/pages/paper.h"

namespace sim::pages {

/// correlation: over frames, of |change of the height since the last frame| with whether a foot touched the
/// ground in the 0.1 s before. p: signed rank test, over steps, that the height changes as much in these 0.1
/// s as in the rest of the step. ratio: how many times as much it changes.
struct ImpactLink {
  double correlation = 0, p = 1, ratio = 1;
};
/// t, z: a height over time; impacts: s, rising. Nothing for fewer than 100 frames or 5 steps.
std::optional<ImpactLink> impact_link(const Column& t, const Column& z, const Column& impacts);

/// Times at which feet touched the ground (s, rising), from the feet.csv of the run; empty without that file.
Column impacts(const RunData& run);

/// The row of the table about this question.
PaperRow impact_row(const std::vector<RunData>& runs, const std::string& filter);

/// Mean |change of the height in a frame| by the time since a foot touched the ground: of the estimate, of
/// truth and of the estimate's error. Without lines where no run has both.
Figure impact_figure(const std::vector<RunData>& runs);

}  // namespace sim::pages
