// From walking commands to footsteps: where each foot lands. The feet are together between commands.
#pragma once

#include <stdexcept>
#include <string>

#include "walking/plan.h"

namespace walking {

/// A walk of more than kLongestWalk_s.
struct TooLong : std::invalid_argument {
  TooLong(int command_, const std::string& why) : std::invalid_argument(why), command(command_) {}
  int command;  ///< index in WalkOptions::commands of the command that makes it too long
};

/// The pose of one sole on the ground, or of the pair: the point below the ankle (m) and the heading (rad,
/// never wrapped).
struct FootPose {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double yaw = 0;
};

/// The landing of one foot.
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

/// Returns `local`, given relative to `frame`, in the frame in which `frame` itself is given.
FootPose operator*(const FootPose& frame, const FootPose& local);

/// The pose that undoes `pose`: inverse(pose) * pose is the identity.
FootPose inverse(const FootPose& pose);

Side other(Side side);

/// The feet together around `center`, spacing_m apart, with its heading.
Stance feet_together(const FootPose& center, double spacing_m);

/// The midpoint between feet that are together.
FootPose center_of(const Stance& stance);

/// Returns the landings of `command` in order, from feet together around `start` to feet together at the
/// command's end. Stand and repeat have none. Throws std::invalid_argument that describes the error in the
/// command.
///
/// `step_length_m` is the advance of the stance's center per step (per pair of steps if the feet move
/// sideways). There are floor(distance / step length) whole steps, one for the remainder, and a closing step
/// (Stasse et al. 2006, section II; the step stack of the JRL pattern generator). Only go_to depends on P: it
/// turns toward its goal, walks straight to it, and turns to the final heading.
std::vector<Footstep> footsteps(const Robot& robot, const Command& command, const FootPose& start,
                                double step_length_m);

/// Returns how far a landing lies outside the area of steps that are known to work, m; 0 inside. As seen from
/// the stance foot, the outer corners of that area are at (0, 1), (±5/7, 3/4) and (±1, 1/2) of the robot's
/// reach ahead and aside (Herdt et al. 2010, as in jrl-walkgen), minus a margin of 0.04 m. On the inside,
/// the soles stay 0.01 m apart.
double distance_outside(const Robot& robot, const FootPose& standing, const Footstep& landing);

}  // namespace walking
