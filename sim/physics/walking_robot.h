// A robot that walks its plan: pattern generator, stabilizer, inverse kinematics and physics, tick by tick.
#pragma once

#include "sim/physics/world.h"
#include "walking/landing_adjustment.h"
#include "walking/pattern_generator.h"
#include "walking/stabilizer.h"

namespace sim::physics {

/// Per tick of 5 ms: command(), the steps of world() until the tick has passed, advance().
class WalkingRobot {
 public:
  /// Starts in the plan's first posture, P at X_WP, and at rest: pads, bushes and servos yield before t = 0.
  WalkingRobot(walking::PatternGenerator plan, const walking::StabilizerOptions& stabilizer,
               const WorldOptions& options, const PlantVariation& draw, const Models& models,
               const Eigen::Isometry3d& X_WP = Eigen::Isometry3d::Identity());

  /// Returns whether the plan continues and the robot is ok.
  bool walks() const { return tick_ < plan_.ticks() && is_ok(); }
  bool is_ok() const { return world_.status().condition == Condition::ok; }
  /// The part of the plan that has been carried out, 0 ... 1.
  double progress() const { return static_cast<double>(tick_) / static_cast<double>(plan_.ticks()); }

  /// Plan -> landing adjustment -> stabilizer -> inverse kinematics -> servos.
  void command(const walking::SensorReadings& readings);
  /// Advances to the next tick of the plan.
  void advance();
  /// A whole tick.
  void tick();

  /// The plan with its adjusted landings, of this tick and of the next one.
  const walking::Reference& reference() const { return adjusted_; }
  walking::Reference following() const { return adjustment_.shifted(following_); }
  walking::PatternGenerator& plan() { return plan_; }
  World& world() { return world_; }
  const World& world() const { return world_; }

 private:
  void step();
  void settle();

  walking::PatternGenerator plan_;
  walking::Reference reference_ = plan_.next(), following_ = plan_.next();
  walking::LandingAdjustment adjustment_;
  walking::Reference adjusted_ = reference_;
  walking::Stabilizer stabilizer_;
  walking::JointVector q_;
  World world_;
  std::size_t tick_ = 0;
};

}  // namespace sim::physics
