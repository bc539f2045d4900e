// The drift of a walk from its plan, decomposed into each foot's motion on the ground and the error of each
// landing. The contributions add up to the drift of the waist.
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
/// The ground part of a nearly upright pose.
Pose2 pose2(const Eigen::Isometry3d& X);

enum class Foot { left, right };

/// One foot at one instant. The creep is since the instant before.
struct FootSample {
  Pose2 truth, plan;
  bool planned_down = true;  ///< the plan has the foot on the ground
  double load = 0;           ///< vertical force as a fraction of the robot's weight
  Pose2 creep;               ///< slip below the friction cone, an artifact of the contact model
};
/// Both feet at one instant.
struct FeetSample {
  Stamp t{0};
  std::array<FootSample, 2> feet;  ///< left, right
};

/// The origin of a contribution.
enum class FootPhase {
  start,     ///< the robot starts beside the plan's start
  put_down,  ///< the foot first touches the ground beside its planned place, as seen from the other foot
  landing,   ///< it moves on the ground before it first carries 40 % of the weight
  support,   ///< until it last carries that much
  lift_off,  ///< until it leaves the ground
  body,      ///< at the end the waist is beside its planned place over the foot
};
inline constexpr std::array<std::string_view, 6> kFootPhases{"start",   "put_down", "landing",
                                                             "support", "lift_off", "body"};

/// One contribution. moved: motion of the point of the sole below the ankle, axes of W; for put_down the true
/// minus the planned place as seen from the other foot; for start and body the same as drift. drift: the
/// share of the waist's final drift, axes of W; zero for a foot that moves while the other one carries the
/// robot.
struct FootRow {
  Stamp begin{0}, end{0};
  Foot foot = Foot::left;
  FootPhase phase = FootPhase::support;
  Pose2 moved, creep, drift;
};

/// Returns the contributions of a whole walk in order of time. samples: at least one, in order of time;
/// waist_truth, waist_plan: at the last.
std::vector<FootRow> decompose_drift(const std::vector<FeetSample>& samples, const Pose2& waist_truth,
                                     const Pose2& waist_plan);

}  // namespace sim::score
