// Shapes of a model as they are drawn: their triangles, their paint and the light on them.
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>

#include "sim/physics/model.h"
#include "sim/score/types.h"

namespace sim::camera {

/// Returns the model's state at its reference positions, with the poses of shapes, cameras and lights
/// computed.
physics::Data data_at_rest(const mjModel& model);

using physics::geom_pose;

/// Triangles in a geom's own frame, counter-clockwise seen from outside.
struct GeomMesh {
  struct Vertex {
    Eigen::Vector3f p, normal;
    Eigen::Vector2f uv{0, 0};  ///< (0, 0) is the picture's upper left, (1, 1) its lower right
  };
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;  ///< three for each triangle
};

/// Returns the triangles of a geom. Planes are drawn only from the front and height fields only from above;
/// round shapes have 20 sides. A picture covers a shape's extent along x and y once or texrepeat times, with
/// its upper left at (-x, +y). It looks right on planes and on two faces of a box. Meshes use their own
/// texture coordinates if they have any.
GeomMesh geom_mesh(const mjModel& model, int geom);

/// Returns the point of a geom's picture (GeomMesh::Vertex::uv) at a point of its surface, which is in the
/// geom's axes. The geom must have a material.
Eigen::Vector2f picture_point(const mjModel& model, int geom, const Eigen::Vector3f& p);

/// Parts of a robot to draw: the head camera does not see the head around it.
enum class Robot { without_head, whole };

/// Returns whether a geom is drawn: groups 0, 1, and 2 (the head) of a whole robot, unless its alpha is 0.
bool is_drawn(const mjModel& model, int geom, Robot robot = Robot::whole);

/// Returns whether light passes through a geom: its alpha is below 1.
bool is_glass(const mjModel& model, int geom);

/// Returns whether a geom belongs to the robot or an actor, not to the room.
inline bool moves(const mjModel& model, int geom) {
  return model.body_weldid[model.geom_bodyid[geom]] != 0 || physics::is_actor(model, geom);
}

/// Returns the 2d texture of a geom's material, or -1 for none.
int texture_of(const mjModel& model, int geom);

/// Returns whether a surface sends light back to depth cameras and lidars: all but window panes and screens,
/// by the names of their materials.
bool returns_light(const mjModel& model, int geom);

/// Color of a surface in full white light, its emission relative to that, and its opacity.
struct Paint {
  Eigen::Vector3f rgb;  ///< 0-1
  float emission = 0;
  float alpha = 1;
};

/// Returns the paint of a geom: its own color or its material's color.
Paint paint_of(const mjModel& model, int geom);

/// The model's lamps: directional ones, fixed to the room, and the ambient part of MuJoCo's headlight. The
/// brightness of a surface does not depend on the view; highlights and cast shadows are omitted.
class Lamps {
 public:
  /// Throws std::invalid_argument for a lamp that is not directional or that moves.
  explicit Lamps(const mjModel& model);
  /// Returns the RGB (0-1) of a surface with this normal in W. `share`: fraction of the lamps' light that is
  /// on.
  Eigen::Vector3f lit(const Paint& paint, const Eigen::Vector3f& normal_W, float share) const;

 private:
  struct Lamp {
    Eigen::Vector3f toward_W, diffuse;
  };
  std::vector<Lamp> lamps_;
  Eigen::Vector3f ambient_;
};

/// Returns all opaque surfaces of the model that never move: the room without the robot. Meshes
/// and height fields become triangles.
std::vector<score::Surface> room_surfaces(const mjModel& model);

}  // namespace sim::camera
