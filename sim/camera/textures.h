// The pictures on a model's surfaces: the model file only names them, so that physics loads fast.
// Soft shadows where furniture stands on the floor or hangs on a wall, baked into the textures of these
// surfaces.
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "sim/camera/gl.h"

namespace sim::camera {
/// The RGB picture of a 2d texture, painted from a seed where paint_texture knows its name, with the shadows
/// that the room's furniture casts on it. `data`: positions computed.
cv::Mat3b texture_picture(const mjModel& model, const mjData& data, int texture, std::uint64_t seed);

/// The model's 2d textures with their mipmaps in the current OpenGL context: those that paint_texture knows
/// by name are painted from a seed, in place of the flat color of the model file.
class Textures {
 public:
  Textures(const mjModel& model, std::uint64_t seed, Channels channels);
  ~Textures();
  Textures(const Textures&) = delete;
  Textures& operator=(const Textures&) = delete;

  /// OpenGL's name of the texture on a geom; 0 for none. Throws std::invalid_argument for a cube texture.
  unsigned on(const mjModel& model, int geom) const;

 private:
  std::vector<unsigned> names_;
};

/// Darkens the picture on a plane of the room under and beside whatever of the room stands close to its
/// front. The picture shows the plane from its front, upper left at (-x, +y) of its frame.
void bake_shadows(cv::Mat3b picture, const mjModel& model, const mjData& data, int plane);

}  // namespace sim::camera
