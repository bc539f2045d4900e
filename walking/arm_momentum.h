// The arms compensate the yaw momentum of the rest of the body: resolved momentum control of the yaw.
#pragma once

#include <utility>

#include "walking/whole_body.h"

namespace walking {

/// Turns the shoulder pitches so that the angular momentum about the vertical through the centre of mass
/// stays that of arms on their way back to half-sitting (Kajita et al. 2003, "Resolved momentum control",
/// with the row L_z selected and the shoulder pitches free; chest and head keep still for camera and IMU).
/// Momentum that alternates from step to step cancels; that of a steady turn is not compensated in the long
/// run.
class ArmMomentum {
 public:
  explicit ArmMomentum(WholeBody model) : model_(std::move(model)) {}

  /// The arms at the next tick of the plan, whose feet and waist `reference` gives.
  Arms operator()(const Reference& reference);

 private:
  Eigen::Vector2d yaw_momentum_of_shoulders(const BodyPose& pose) const;

  WholeBody model_;
  Reference last_;
  Eigen::Vector2d swing_ = Eigen::Vector2d::Zero();  // right and left shoulder from half-sitting, rad
  bool started_ = false;
};

}  // namespace walking
