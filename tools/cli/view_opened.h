// What the views of runs, replays and results share.
#pragma once

#include "sim/view/access.h"
#include "sim/view/strips.h"
#include "tools/cli/view_session.h"

namespace cli {

sim::view::Access access_of(const ViewPlace& place);

/// Prints where the view is.
void announce(const sim::view::Access& access);

/// Adds the image, what the estimator made of it and, where it is wanted, the map.
void add_tracked(sim::view::Frame& frame, const slam::Observation& observation,
                 const sim::tracking::Tracking* tracking, bool with_map);

}  // namespace cli
