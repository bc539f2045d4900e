// Corrects the footsteps of a walk by estimates of the robot's place.
#pragma once

#include "walking/pattern_generator.h"

namespace walking {

/// An estimate of the robot's place: its support sole as planned, in the plan's world P, and as estimated, in
/// W. Yaw: of any axis of the robot, the same one in both.
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
  FootPose expected;     ///< landing without the correction, as estimated, in W
  FootPose error;        ///< of the expected landing: the desired one seen from it (ahead, aside; turn)
  FootPose correction;   ///< the landing seen from the uncorrected one (ahead, aside; turn)
};

/// The desired path is that of the scenario's commands in W; the plan lives in P, which stays continuous, and
/// an estimate gives the drift of P in W. Each landing is moved toward the path as late as it can be changed,
/// by a limited correction, so that an estimate that jumps does not make the walk jump.
class Steering {
 public:
  /// plan: from its first tick on, as yet uncorrected.
  Steering(const SteeringOptions& options, const PatternGenerator& plan);

  /// Returns whether decide() must be called at this tick, before plan.next().
  bool is_due(const PatternGenerator& plan, std::size_t tick) const;

  /// Corrects the step that is due; after the last one adds steps while the robot is not within the tolerance
  /// of the end of the path. newest: the newest usable estimate, if any.
  void decide(PatternGenerator& plan, std::size_t tick, const std::optional<PlaceEstimate>& newest);

  const std::vector<StepCorrection>& corrections() const { return corrections_; }
  /// Time when a lost estimate stopped the walk, s.
  std::optional<double> stopped_s() const { return stopped_s_; }

 private:
  void add(const PlaceEstimate& newest);
  void correct(PatternGenerator& plan, double now_s);
  void stop(PatternGenerator& plan, double now_s);
  void approach_goal(PatternGenerator& plan);
  FootPose error_of(const FootPose& desired) const;
  Eigen::Vector3d sigma_at(const FootPose& landing) const;
  FootPose limited(const FootPose& error, const Eigen::Vector3d& sigma) const;
  std::vector<Footstep> planned_from(std::size_t step) const;

  SteeringOptions options_;
  std::vector<Footstep> desired_;  // in W
  FootPose X_PW_plan_;             // from the path to its plan: the corrections so far
  FootPose X_WP_;                  // the newest estimate of the plan's world
  std::optional<PlaceEstimate> newest_;
  int final_steps_ = 0;  // added
  std::vector<StepCorrection> corrections_;
  std::optional<double> stopped_s_;
};

}  // namespace walking
