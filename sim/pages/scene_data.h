// The map in three dimensions, as JSON: paths, landmarks and the camera's poses with their ellipsoids.
#pragma once

#include <nlohmann/json.hpp>

#include "sim/pages/run_data.h"

namespace sim::pages {

/// {plan, truth, estimate: {x, y, z}, maps: [{t, landmarks: [{p, axes}]}], poses: [{t, p, q, axes}]}; all in
/// W, m, s; q (x, y, z, w); axes: rows of the matrix that maps the unit sphere to the 3-sigma ellipsoid. The
/// run must have a map and an estimate.
nlohmann::ordered_json scene_data(const RunData& run);

}  // namespace sim::pages
