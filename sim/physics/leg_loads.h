// The load of each sole by the torques of its leg, for robots without force sensors at the ankles.
#pragma once

#include "sim/physics/model.h"
#include "walking/stabilizer.h"

namespace sim::physics {

/// Computes with the robot's nominal model, which no seed varies.
class LegLoads {
 public:
  LegLoads(Model on_floor, const walking::Robot& robot);

  /// Returns the wrench of the ground on the left and on the right foot: J^T f + tau = g(q) of the six joints
  /// of a leg. The waist counts as upright, and the links' inertia is neglected: while a leg swings that is
  /// some tens of N.
  std::array<walking::Wrench, 2> wrenches(const walking::JointVector& q,
                                          const walking::JointVector& torque) const;

 private:
  Model model_;
  Data data_;
  std::array<walking::Leg, 2> legs_;  // left, right
  std::array<int, 2> soles_;          // sites
};

}  // namespace sim::physics
