// The drift of a walk from its plan decomposed into contributions: each foot's motion on the ground and each
// landing beside its planned place. They add up to the drift of the waist.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/score/trajectory.h"

namespace sim::score {

/// A pose on the ground: x, y (m) and yaw (rad).
struct Pose2 {
  double x = 0, y = 0, yaw = 0;
};
/// The ground part of a pose whose z axis is nearly vertical.
Pose2 pose2(const Eigen::Isometry3d& X);

enum class Foot { left, right };

/// One foot at one instant. The creep is since the instant before.
struct FootSample {
  Pose2 truth, plan;
  bool planned_down = true;  ///< by the plan the foot stands
  double load = 0;           ///< vertical force as a fraction of the robot's weight
  Pose2 creep;               ///< slip below the friction cone, an artefact of the contact model
};
/// Both feet at one instant.
struct FeetSample {
  Stamp t{0};
  std::array<FootSample, 2> feet;  ///< left, right
};

/// What a contribution comes from.
enum class FootPhase {
  start,     ///< the robot begins beside the plan's start
  put_down,  ///< the foot first touches the ground beside its planned place, as seen from the other foot
  landing,   ///< it moves on the ground until it first carries 40 % of the weight
  support,   ///< until it last does
  lift_off,  ///< until it leaves the ground
  body,      ///< at the end the waist is beside its place over the foot
};
inline constexpr std::array<std::string_view, 6> kFootPhases{"start",   "put_down", "landing",
                                                             "support", "lift_off", "body"};

/// One contribution. moved: motion of the point of the sole below the ankle, end minus begin, axes of W; of
/// put_down: true minus planned place as seen from the other foot; of start and body: as drift. drift: share
/// in the waist's drift at the end, axes of W; all shares add up to it. A foot that moves while the other one
/// carries the motion of the robot has no share.
struct FootRow {
  Stamp begin{0}, end{0};
  Foot foot = Foot::left;
  FootPhase phase = FootPhase::support;
  Pose2 moved, creep, drift;
};

/// The contributions of a whole walk in order of time. Samples in order of time, at least one; waist_plan,
/// waist_truth: at the last.
std::vector<FootRow> decompose_drift(const std::vector<FeetSample>& samples, const Pose2& waist_truth,
                                     const Pose2& waist_plan);

}  // namespace sim::score
