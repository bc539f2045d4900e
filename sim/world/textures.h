// Gives a model's textures their painted pictures: the model file only names them, so that physics loads
// fast.
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>

namespace sim::world {

/// Paints each of the model's 2d textures that paint_texture knows by name, and loads it with its mipmaps
/// into the current OpenGL context in place of the flat colour of the model file.
void upload_textures(const mjModel& model, const mjrContext& context, std::uint64_t seed);

}  // namespace sim::world
