// Soft shadows where furniture stands on the floor or hangs on a wall, baked into the textures of these
// surfaces.
#pragma once

#include <mujoco/mujoco.h>

#include <opencv2/core.hpp>

namespace sim::world {

/// Darkens the picture on a plane of the room under and beside whatever of the room stands close to its
/// front. The picture shows the plane from its front, upper left at (-x, +y) of its frame.
void bake_shadows(cv::Mat3b picture, const mjModel& model, const mjData& data, int plane);

}  // namespace sim::world
