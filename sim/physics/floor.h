// The floor that a robot steps on.
#pragma once

#include "sim/physics/model.h"
#include "walking/pattern_generator.h"

namespace sim::physics {

/// A point of the floor.
struct FloorPoint {
  double z = 0;  ///< m
  int geom = -1;
};

/// All shapes of a model that do not move: planes, boxes, height fields and other primitives. The model must
/// outlive this object.
class Floor {
 public:
  explicit Floor(const mjModel_& on_floor);

  /// Returns whether the floor is the plane z = 0 with the robot's own friction.
  bool is_plain() const { return plain_; }
  /// Returns the highest point of the floor at a place, or nothing off the floor. Positions in `data` must
  /// have been computed.
  std::optional<FloorPoint> at(const mjData_& data, const Eigen::Vector2d& p_W) const;
  /// Returns at().z, or 0 off the floor.
  double height(const mjData_& data, const Eigen::Vector2d& p_W) const;
  /// Returns the sliding friction of the floor at a place, relative to the robot's.
  double friction(const mjData_& data, const Eigen::Vector2d& p_W) const;
  /// Returns how many shapes are neither planes nor height fields.
  std::size_t solids() const;

 private:
  const mjModel_& model_;
  std::vector<int> geoms_;
  bool plain_ = false;
};

/// Many solid shapes make each physics step slow, because each is compared with each contact of the robot.
inline constexpr std::size_t kMostSolids = 100;

/// The slope and the edges that the built-in controller walks with `slope: true`: 7 degrees. On 8 and on 3 cm it
/// falls.
inline constexpr double kSteepest_deg = 7.5, kHighestEdge_m = 0.02;

/// A planned footstep onto a place where the floor is not z = 0, or is too steep.
struct UnevenStep {
  double t_s = 0;
  int command = 0;  ///< index into WalkOptions::commands
  bool left = false;
  std::string geom;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< on the floor
};

/// Returns the plan's first footstep onto such a place. P is W. slopes: only if it is too steep.
std::optional<UnevenStep> first_uneven_step(walking::PatternGenerator plan, const Model& on_floor,
                                            bool slopes = false);

}  // namespace sim::physics
