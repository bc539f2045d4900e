// Moves the foothold of the swinging foot by the error of the capture point, and the plan's frame with it.
#pragma once

#include "walking/stabilizer.h"

namespace walking {

/// The capture point diverges from the ZMP as exp(omega t) (Englsberger et al. 2011). The error predicted for
/// touch-down moves the foothold; after touch-down the plan continues in a frame shifted by as much.
///
/// A landing stays in the area of distance_outside() and within the reach of the leg, and no longer moves
/// once the foot has touched down early.
class LandingAdjustment {
 public:
  LandingAdjustment(const Robot& robot, const StabilizerOptions::LandingAdjustment& options);

  /// Returns the reference of this tick with frame and feet shifted; one call for each tick of the plan.
  /// state: of the stabilizer at the tick before.
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
  // Shifts in P, m: of the plan's frame, with its start and end while it moves, and of both feet.
  Eigen::Vector2d frame_ = Eigen::Vector2d::Zero(), from_ = frame_, to_ = frame_, left_ = frame_,
                  right_ = frame_;
  double progress_ = 1;            // of the frame's motion, 0 ... 1
  std::optional<Side> swung_;      // the foot in the air at the last tick
  bool has_touched_down_ = false;  // before its time
};

}  // namespace walking
