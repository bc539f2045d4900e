// Corrects the footsteps of a walk using estimates of the robot's place.
#pragma once

#include "walking/pattern_generator.h"

namespace walking {

/// An estimate of the robot's place: its support sole as planned, in the plan's world P, and as estimated, in
/// W. The yaw may be of any axis of the robot, but must be of the same axis in both.
struct PlaceEstimate {
  double t_s = 0;
  FootPose planned, estimated;
  /// Covariance of `estimated`: x, y (m, axes of W), yaw (rad).
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// Returns the place by leg odometry at the time of `planned`. X_OB: the base, in the odometry's world.
/// Without a plan, the base itself is the place.
PlaceEstimate place_by_legs(const Eigen::Isometry3d& X_OB, const Reference& planned, bool has_plan);

/// The correction of one footstep.
struct StepCorrection {
  std::size_t step = 0;
  double decided_s = 0;  ///< time of the decision
  Footstep desired;      ///< landing on the desired path, in W
  FootPose expected;     ///< estimated landing without the correction, in W
  FootPose error;        ///< the desired landing seen from the expected one (ahead, aside; turn)
  FootPose correction;   ///< the landing seen from the uncorrected one (ahead, aside; turn)
};

/// The desired path is the path of the scenario's commands, in W. The plan is expressed in P,
/// which stays continuous, and an estimate gives the drift of P in W. Each landing is moved toward the path
/// at the last moment at which it can be changed. The correction is limited, so that the walk does not follow
/// a jump of the estimate at once.
class Steering {
 public:
  /// plan: still at its first tick and uncorrected.
  Steering(const SteeringOptions& options, const PatternGenerator& plan);

  /// Returns whether decide() must be called at this tick, before plan.next().
  bool is_due(const PatternGenerator& plan, std::size_t tick) const;

  /// Corrects the step that is due. After the last step, adds steps as long as the robot is not within the
  /// tolerance of the end of the path. newest: the newest usable estimate, if any.
  void decide(PatternGenerator& plan, std::size_t tick, const std::optional<PlaceEstimate>& newest);

  const std::vector<StepCorrection>& corrections() const { return corrections_; }
  /// The time when a lost estimate stopped the walk, s.
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
  FootPose X_PW_plan_;             // from the path to the plan: the corrections so far
  FootPose X_WP_;                  // newest estimate of the pose of the plan's world
  std::optional<PlaceEstimate> newest_;
  int final_steps_ = 0;  // number of steps added at the end
  std::vector<StepCorrection> corrections_;
  std::optional<double> stopped_s_;
};

}  // namespace walking
