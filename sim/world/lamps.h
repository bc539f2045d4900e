// The light of a room on its surfaces.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <vector>

namespace sim::world {

/// What a surface looks like in full white light, and what it shines with by itself, as a share of that.
struct Paint {
  Eigen::Vector3f rgb;  ///< 0-1
  float emission = 0;
};

/// The paint of a geom: its own colour or that of its material.
Paint paint_of(const mjModel& model, int geom);

/// The model's lamps: directional ones, fixed to the room, and the ambient part of MuJoCo's headlight. What
/// moves with the head lights nothing, so that the brightness of a surface does not depend on the view; there
/// are no highlights and no cast shadows.
class Lamps {
 public:
  /// `data`: positions computed (mj_kinematics and mj_camlight). Throws std::invalid_argument for a lamp that
  /// is not directional or that moves.
  Lamps(const mjModel& model, const mjData& data);

  /// RGB, 0-1, of a surface of that normal in W. `share` of the lamps' light is on.
  Eigen::Vector3f lit(const Paint& paint, const Eigen::Vector3f& normal_W, float share) const;

 private:
  struct Lamp {
    Eigen::Vector3f towards_W, diffuse;
  };
  std::vector<Lamp> lamps_;
  Eigen::Vector3f ambient_;
};

}  // namespace sim::world
