// The room as primitive shapes, so that a ray can be cast at it without the simulator.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <vector>

namespace sim::camera {

/// One visible, unmoving surface of the room.
struct RoomPrimitive {
  enum class Kind { plane, box, sphere, cylinder, ellipsoid, capsule };
  Kind kind;
  Eigen::Isometry3d X_WS;  ///< its frame: cylinder and capsule along z, a plane's front towards +z
  Eigen::Vector3d
      size;  ///< half extents; plane (x, y, 0), sphere (r, r, r), cylinder and capsule (r, r, half length)
};

/// All surfaces of the model that are drawn and never move: the room without the robot. Throws
/// std::invalid_argument for a shape that is not a primitive (mesh, height field) and for an infinite plane.
std::vector<RoomPrimitive> room_primitives(const mjModel& model);

}  // namespace sim::camera
