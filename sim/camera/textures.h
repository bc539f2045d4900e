// The pictures on a model's surfaces: the model file only names them, so that physics loads fast.
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "sim/camera/gl.h"

namespace sim::camera {

/// The RGB picture of a 2d texture, painted from a seed where paint_texture knows its name. Soft shadows of
/// the furniture that stands on a floor or hangs on a wall are baked into it. `data`: positions computed.
cv::Mat3b texture_picture(const mjModel& model, const mjData& data, int texture, std::uint64_t seed);

/// Loads the model's 2d textures with their mipmaps in the current OpenGL context. Returns OpenGL's names, by
/// the model's numbers.
std::vector<unsigned> load_textures(const mjModel& model, std::uint64_t seed, Channels channels);

}  // namespace sim::camera
