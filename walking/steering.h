// Corrects the footsteps of a walk by estimates of where the robot is.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "walking/footsteps.h"
#include "walking/pattern_generator.h"
#include "walking/plan.h"

namespace walking {

/// Where the robot is believed to be at a time: the place of its support sole as planned, in the plan's world
/// P, and as estimated, in W. Yaw: of any axis of the robot, the same one in both.
struct PlaceEstimate {
  double t_s = 0;
  FootPose planned, estimated;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of estimated: x, y (m, axes of W), yaw (rad)
};

/// How one footstep was corrected.
struct StepCorrection {
  std::size_t step = 0;
  double decided_s = 0;  ///< time of the decision
  Footstep desired;      ///< of the path, in W
  FootPose expected;     ///< where the foot would land uncorrected by the estimate, in W
  FootPose error;        ///< of the expected landing: the desired one seen from it (ahead, aside; turn)
  FootPose correction;   ///< the landing seen from the uncorrected one (ahead, aside; turn)
};

/// The desired path is that of the scenario's commands with the plan's world P laid on W; the plan lives in
/// P, which stays continuous, and an estimate says where P has drifted to in W. Each landing, at the last
/// moment at which it can be changed, is moved towards where the path wants it. How far is limited for each
/// step, so that an estimate that jumps (a loop closes, a place is recognized) does not make the walk jump.
class Steering {
 public:
  /// plan: from its first tick on, as yet uncorrected.
  Steering(const SteeringOptions& options, const PatternGenerator& plan);

  /// Whether decide() is to be called at this tick of the walk, before plan.next().
  bool is_due(const PatternGenerator& plan, std::size_t tick) const;

  /// Corrects the step that is due; after the last one adds steps while the robot is not within the tolerance
  /// of the end of the path. newest: the newest estimate that may be used, nothing if there is none.
  void decide(PatternGenerator& plan, std::size_t tick, const std::optional<PlaceEstimate>& newest);

  const std::vector<StepCorrection>& corrections() const { return corrections_; }
  /// When the walk was ended early for want of an estimate, s; nothing if it was not.
  std::optional<double> stopped_s() const { return stopped_s_; }

 private:
  void take(const PlaceEstimate& newest);
  void correct(PatternGenerator& plan, double now_s);
  void stop(PatternGenerator& plan, double now_s);
  void approach_goal(PatternGenerator& plan);
  FootPose error_of(const FootPose& desired) const;
  Eigen::Vector3d sigma_at(const FootPose& landing) const;
  FootPose limited(const FootPose& error, const Eigen::Vector3d& sigma) const;
  std::vector<Footstep> planned_from(std::size_t step) const;

  SteeringOptions options_;
  std::vector<Footstep> desired_;  // in W
  FootPose X_PW_plan_;             // moves the path to where it is planned: the corrections so far
  FootPose X_WP_;                  // the newest estimate of where the plan's world is
  std::optional<PlaceEstimate> newest_;
  int final_steps_ = 0;  // added
  std::vector<StepCorrection> corrections_;
  std::optional<double> stopped_s_;
};

}  // namespace walking
