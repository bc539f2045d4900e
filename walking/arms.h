// Motions of the arms that make up for yaw momentum of the legs.
#pragma once

#include <utility>

#include "walking/kinematics.h"
#include "walking/plan.h"

namespace walking {

/// Returns the arm for a foot on its side that is `foot_ahead_m` ahead of half-sitting: the hand goes the
/// other way by 0.2267747 of that, at its height in half-sitting (Stasse et al. 2006, section II: "arm motion
/// heuristic"; gain and geometry of the JRL pattern generator). Half-sitting for 0.
ArmAngles arm_swing(double foot_ahead_m);

/// Both arms for the feet of `reference`.
Arms arm_swing(const Reference& reference);

/// Turns the shoulder pitches so that the angular momentum about the vertical through the center of mass
/// stays that of arms on their way back to half-sitting (Kajita et al. 2003, "Resolved momentum control",
/// with the row L_z selected and the shoulder pitches free; chest and head keep still for camera and IMU).
/// Momentum that alternates from step to step cancels; that of a steady turn is not compensated in the long
/// run.
class ArmMomentum {
 public:
  explicit ArmMomentum(WholeBody model) : model_(std::move(model)) {}

  /// The arms at the next tick of the plan. `reference`: its feet and waist.
  Arms operator()(const Reference& reference);

 private:
  Eigen::Vector2d yaw_momentum_of_shoulders(const BodyPose& pose) const;

  WholeBody model_;
  Reference last_;
  Eigen::Vector2d swing_ = Eigen::Vector2d::Zero();  // right and left shoulder from half-sitting, rad
  bool started_ = false;
};

}  // namespace walking
