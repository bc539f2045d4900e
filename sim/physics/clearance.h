// The robot's distance from the walls and furniture of its room, and checks of a plan against them.
#pragma once

#include "sim/physics/model.h"
#include "walking/pattern_generator.h"

namespace sim::physics {

/// No part of the robot moves faster than this (m/s); a fall from human height reaches half of it. If the
/// distance to the room is d, nothing can touch the room within d / kFastest_m_s.
inline constexpr double kFastest_m_s = 10;

/// A link of the robot that touches an object in the room or is closer to it than allowed.
struct Collision {
  std::string link;     ///< a body of the robot
  std::string object;   ///< the name of the shape in the room's model, or else of its body or its material
  Eigen::Vector3d p_W;  ///< where, m
};

struct Clearance {
  /// Lower bound of the distance between robot and room, from boxes around both; that from actors is
  /// reduced so that no part of the robot touches one within distance_m / kFastest_m_s.
  double distance_m = 0;
  std::optional<Collision> collision;
};

/// The room is solid as it is drawn: all of its shapes above the floor, with planes as thin sheets. The robot
/// comprises all of its drawn shapes and its soles.
class RoomClearance {
 public:
  /// margin_m: anything closer than this is a collision; 0: only touching is.
  explicit RoomClearance(Model in_room, double margin_m = 0);

  /// positions: all positions (qpos) of the robot's model. t_s: the time of the actors.
  Clearance at(const double* positions, double t_s = 0);

  const mjModel_& model() const { return *model_; }

 private:
  struct Solid {
    int geom = 0;
    Eigen::AlignedBox3d box;  // around the shape, in W
    bool moves = false;
  };

  Eigen::AlignedBox3d robot_box() const;
  double select_near(const Eigen::AlignedBox3d& robot);
  Collision collision(int robot_geom, int room_geom, const Eigen::Vector3d& p_W) const;
  bool is_robot(int geom) const;

  Model model_;
  Data data_;
  double margin_;
  std::vector<int> robot_;
  std::vector<Solid> solids_;
};

/// The minimum distance of a planned robot from the room, in m, to allow for sway about the plan. A long walk
/// drifts farther; a run that touches something because of that ends as "collided".
inline constexpr double kPlannedMargin_m = 0.05;

struct PlannedCollision : Collision {
  double t_s = 0;
  int command = 0;  ///< index into WalkOptions::commands
};

/// Returns the first time at which the planned posture is closer than kPlannedMargin_m to the room. P is W.
std::optional<PlannedCollision> first_collision(walking::PatternGenerator plan, Model in_room);

}  // namespace sim::physics
