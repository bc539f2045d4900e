// Moves the foothold of the swinging foot, and the plan's frame with it, by the error of the capture point.
#pragma once

#include "walking/stabilizer.h"

namespace walking {

/// The capture point diverges from the ZMP as exp(omega t) (Englsberger et al. 2011). The foothold moves by
/// the error predicted for touch-down; after touch-down, the plan continues in a frame shifted by the same
/// amount.
///
/// A landing stays in the area of distance_outside() and within the reach of the leg, and stops moving if the
/// foot touches down early.
class LandingAdjustment {
 public:
  LandingAdjustment(const Robot& robot, const StabilizerOptions::LandingAdjustment& options);

  /// Returns the reference of this tick with the frame and feet shifted. Call it once for each tick of the
  /// plan. state: the stabilizer's at the previous tick.
  Reference adjust(const Reference& planned, const StabilizerState& state, const SensorReadings& readings);

  /// Returns a reference with the shifts of the last tick.
  Reference shifted(Reference planned) const;

 private:
  Eigen::Vector2d wanted(const Reference& planned, const StabilizerState& state) const;
  void move_foothold(const Reference& planned, const StabilizerState& state, const SensorReadings& readings);
  bool allows(const Reference& planned, const Eigen::Vector2d& shift, const JointVector& q) const;
  Eigen::Vector2d& foot(Side side) { return side == Side::left ? left_ : right_; }
  const Eigen::Vector2d& foot(Side side) const { return side == Side::left ? left_ : right_; }

  Robot robot_;
  StabilizerOptions::LandingAdjustment options_;
  double omega_;  // 1/s
  // Shifts of the plan's frame (now, and at the start and end of its motion) and of both feet, m in P.
  Eigen::Vector2d frame_ = Eigen::Vector2d::Zero(), from_ = frame_, to_ = frame_, left_ = frame_,
                  right_ = frame_;
  double progress_ = 1;            // completed part of the frame's motion, 0 to 1
  std::optional<Side> swung_;      // the foot in the air at the last tick
  bool has_touched_down_ = false;  // earlier than planned
};

}  // namespace walking
