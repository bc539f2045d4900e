// Whether the estimated height jumps when feet hit the ground: the paper saw no link and could not say.
#pragma once

#include <optional>
#include <vector>

#include "sim/report/paper.h"

namespace sim::report {

/// The correlation, over frames, of |change of the estimated height in the frame| with whether a foot touched
/// the ground in the 0.1 s before; p: the share of circular shifts of the impacts (which keep their rhythm)
/// that correlate as much.
struct ImpactLink {
  double correlation = 0, p = 1;
  int frames = 0;
};
/// t, z: the estimated height over time; impacts: s. Nothing for fewer than 100 frames or without an impact.
std::optional<ImpactLink> impact_link(const Column& t, const Column& z, const Column& impacts);

/// The line of the table.
PaperRow impact_row(const std::vector<RunData>& runs);

}  // namespace sim::report
