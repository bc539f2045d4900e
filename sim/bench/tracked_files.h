// The tables of a result folder that tell frame by frame what the filter did, and the map it ended with.
#pragma once

#include <filesystem>

#include "sim/bench/tracking.h"

namespace sim::bench {

/// Writes frames.csv, map.csv, map_over_time.csv (second by second), searches.csv (each ellipse in which a
/// landmark was looked for, and where it was found) and, where landmarks began as lines, depths.csv (every
/// hypothesis of their depths). Throws FileError.
void write_tracked(const std::filesystem::path& folder, const Tracked& tracked);

}  // namespace sim::bench
