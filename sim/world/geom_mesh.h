// The surface of a geom as triangles.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace sim::world {

/// Triangles in a geom's own frame, counter-clockwise seen from outside.
struct GeomMesh {
  struct Vertex {
    Eigen::Vector3f p, normal;
    Eigen::Vector2f uv{
        0, 0};  ///< texture coordinates: (0, 0) is the picture's upper left, (1, 1) its lower right
  };
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;  ///< three for each triangle
};

/// Planes have a front alone; round shapes are 20-sided. A picture covers a shape's extent along its x and y
/// once, or as the material's texrepeat and texuniform say, upper left at (-x, +y): well mapped on planes and
/// on two faces of a box. Throws std::invalid_argument for height fields.
GeomMesh geom_mesh(const mjModel& model, int geom);

}  // namespace sim::world
