// From walking commands to footsteps: where each foot lands; feet are together between commands.
#pragma once

#include <stdexcept>
#include <string>

#include "walking/plan.h"

namespace walking {

/// A walk of more than kLongestWalk_s.
struct TooLong : std::invalid_argument {
  TooLong(int command_, const std::string& why) : std::invalid_argument(why), command(command_) {}
  int command;  ///< index into WalkOptions::commands of the one that makes it so
};

/// A sole on the ground, or both: the point below the ankle (m) and the heading (rad, never wrapped).
struct FootPose {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double yaw = 0;
};

/// One foot coming down at its place.
struct Footstep {
  Side side;
  FootPose pose;
};

/// Poses of both standing feet.
struct Stance {
  FootPose left, right;

  const FootPose& of(Side side) const { return side == Side::left ? left : right; }
  FootPose& of(Side side) { return side == Side::left ? left : right; }
};

/// `local` given in the frame of `frame`, in the frame that `frame` itself is given in.
FootPose operator*(const FootPose& frame, const FootPose& local);

/// The pose that undoes `pose`: inverse(pose) * pose is the identity.
FootPose inverse(const FootPose& pose);

Side other(Side side);

/// Feet together around `center`, so far apart, with its heading.
Stance feet_together(const FootPose& center, double spacing_m);

/// Half way between feet that are together.
FootPose center_of(const Stance& stance);

/// Returns the landings of `command`, the first foot to move first, from feet together around `start` to feet
/// together at the command's end; none for Stand and repeat. Throws std::invalid_argument naming what is
/// wrong with the command.
///
/// `step_length_m` is the advance of the stance's center per step (per pair of steps if the feet go
/// sideways): floor(distance / step length) whole steps, one for the rest, and the closing one (Stasse et al.
/// 2006, section II; the step stack of the JRL pattern generator). Only go_to depends on P: it turns to its
/// goal, walks straight to it and turns to the heading there.
std::vector<Footstep> footsteps(const Robot& robot, const Command& command, const FootPose& start,
                                double step_length_m);

/// Returns how far a landing is outside the area of steps that are known to work, m; 0 inside. Seen from the
/// stance foot, its outer corners are the robot's reach aside, (±5/7, 3/4) and (±1, 1/2) of its reach ahead
/// and aside (Herdt et al. 2010, as in jrl-walkgen), less a margin of 0.04 m; on the inside the soles stay
/// 0.01 m apart.
double distance_outside(const Robot& robot, const FootPose& standing, const Footstep& landing);

}  // namespace walking
