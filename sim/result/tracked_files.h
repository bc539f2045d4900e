// The CSV files of a result folder that say what the filter did in each frame, and its map.
#pragma once

#include <filesystem>

#include "sim/tracking/tracking.h"

namespace sim::result {

/// Writes frames.csv (each frame), map.csv (the map at the end), landmarks.csv (where each
/// landmark was first seen), map_over_time.csv (the map each second),
/// searches.csv (each ellipse in which a landmark was searched for, where it was found, and where a
/// match was refused) and, if landmarks
/// were initialized as lines, depths.csv (every hypothesis of their depths). Throws FileError.
void write_tracked(const std::filesystem::path& folder, const tracking::Tracked& tracked);

}  // namespace sim::result
