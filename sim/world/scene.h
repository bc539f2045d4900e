// Pictures of a MuJoCo model from any pose: the room, the robot in it, drawn off-screen.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>

#include "sim/world/gl_context.h"
#include "sim/world/lens.h"

namespace sim::world {

/// Draws a model's geoms with its textures painted from a seed. Owns the OpenGL context of its thread.
class Scene {
 public:
  /// Pictures of at most width x height px. Throws std::runtime_error when there is no OpenGL.
  Scene(const mjModel& model, int width_px, int height_px, int samples, std::uint64_t texture_seed);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// RGB picture of `data` (positions computed), rows from the bottom up, seen by `pinhole` from X_WC (x
  /// right, y down, z forward). Geoms of groups 0 and 1 are drawn, and of group 2 (the head) when asked for.
  /// `light`: share of the room's light that is on; what shines by itself is as bright as ever, but for the
  /// ceiling, which holds the lamps.
  cv::Mat3b draw(const mjData& data, const Eigen::Isometry3d& X_WC, const Pinhole& pinhole, bool head,
                 float light = 1);

 private:
  void dim(float light);
  void place_camera(const Eigen::Isometry3d& X_WC, const Pinhole& pinhole);
  void cover_unsampled(const Eigen::Isometry3d& X_WC, const Pinhole& pinhole);
  void cull_and_sort(const Eigen::Isometry3d& X_WC, const Pinhole& pinhole);

  const mjModel& model_;
  GlContext gl_;
  mjvScene scene_{};
};

}  // namespace sim::world
