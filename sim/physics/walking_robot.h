// A walking robot: its controller and the physics, tick by tick.
#pragma once

#include <memory>

#include "sim/controllers/plan_controller.h"
#include "sim/physics/world.h"
#include "sim/programs/child_program.h"
#include "walking/leg_odometry.h"

namespace sim::physics {

/// For each tick of 5 ms: command(), steps of world() until the tick is over, advance().
class WalkingRobot {
 public:
  /// Starts in the controller's start posture, with P at X_WP; pads, bushings and servos settle before t = 0.
  /// If the controller requires it, the base is first lowered to the floor. If `legs` is given and the
  /// controller has no plan, leg odometry follows the base after its release. A walk without a plan begins
  /// at the true pose of the base on the floor at t = 0.
  WalkingRobot(std::unique_ptr<controllers::Controller> controller, const WorldOptions& options,
               const PlantVariation& draw, const Models& models,
               const Eigen::Isometry3d& X_WP = Eigen::Isometry3d::Identity(),
               walking::LegOdometry* legs = nullptr);
  /// Does the same with the built-in controller.
  WalkingRobot(walking::PatternGenerator plan, const walking::StabilizerOptions& stabilizer,
               const WorldOptions& options, const PlantVariation& draw, const Models& models,
               const Eigen::Isometry3d& X_WP = Eigen::Isometry3d::Identity());

  /// Returns whether the walk continues and the robot is ok.
  bool walks() const { return controller_->walks() && is_ok(); }
  bool is_ok() const { return !failure_ && world_.status().condition == Condition::ok; }
  double progress() const { return controller_->progress(); }
  /// Returns the failure of an external controller, if any.
  const std::optional<programs::ProgramFailed>& failure() const { return failure_; }

  /// From controller to servos.
  void command(const walking::SensorReadings& readings) { command(readings, false); }
  /// Advances to the next tick of the walk.
  void advance() { controller_->advance(); }
  /// At the end of a tick, corrects a due footstep or a commanded velocity by leg odometry, which has the
  /// readings at the tick's start.
  void steer(const walking::LegOdometry& legs);
  /// Runs a whole tick, with the readings at its start for leg odometry, which steers if there is one.
  /// disturb: adds noise to the readings.
  void tick(walking::LegOdometry* legs = nullptr,
            const std::function<void(walking::SensorReadings&)>& disturb = {});

  /// The plan with its adjusted landings, or the commanded path, at this tick and at the next one.
  const walking::Reference& reference() const { return controller_->reference(); }
  walking::Reference following() const { return controller_->following(); }
  controllers::Controller& controller() { return *controller_; }
  const controllers::Controller& controller() const { return *controller_; }
  World& world() { return world_; }
  const World& world() const { return world_; }

 private:
  void command(const walking::SensorReadings& readings, bool settles);
  void step();
  void lower(walking::LegOdometry* legs);
  void settle();

  std::unique_ptr<controllers::Controller> controller_;
  std::optional<programs::ProgramFailed> failure_;
  World world_;
};

}  // namespace sim::physics
