// A run before its first tick: a checked plan, the robot for its seed, and its sensors.
#pragma once

#include <cstdint>

#include "sim/controllers/program_controller.h"
#include "sim/physics/world.h"
#include "sim/recording/recording.h"
#include "sim/rig/rig.h"
#include "sim/scenario/scenario.h"
#include "sim/sensor_errors/random.h"
#include "walking/pattern_generator.h"
#include "walking/plan.h"

namespace sim::live {

/// Returns the plan of the walk. Throws std::invalid_argument if it cannot be planned. Throws ConfigError at
/// a walk command if its planned posture is too close to a wall or furniture, unless the scenario allows a
/// run to end as "collided". slopes: the controller follows slopes, so only footsteps that are too steep are
/// errors, unless the scenario allows a run to end as "fell".
walking::PatternGenerator clear_plan(const scenario::ReadScenario& read, const physics::Models& models,
                                     bool slopes = false);

/// Starts the program of walk.controller. Throws std::invalid_argument if it cannot be started or does not
/// accept the start.
std::unique_ptr<controllers::ProgramController> program_controller(const scenario::ReadScenario& read,
                                                                   const physics::Models& models);

/// Returns the variations. Each is drawn from its own named stream, so a spread of 0 does not change the
/// others.
physics::PlantVariation plant_variation(std::uint64_t seed, const physics::WorldOptions& world, int joints);

/// Arranges the room as the scenario says. Throws ConfigError if no furniture can be moved.
void arrange(const scenario::ReadScenario& read, physics::Models& models);

/// Moves the head camera and chest IMU of the models to the scenario's mounts. Throws ConfigError if one of
/// their links, or of the rig's, does not exist.
void mount_sensors(const scenario::ReadScenario& read, physics::Models& models);

/// Returns where a scenario's rig items are on the robot; a depth camera is where the head camera is.
std::vector<physics::Place> places(const std::vector<rig::Item>& rig, const mjModel_& model);

/// Places of head camera and chest IMU on the robot in its start posture, in the nominal model.
struct Mounting {
  Eigen::Isometry3d X_BC, X_CG;
  std::vector<Eigen::Isometry3d> X_CL;  ///< the rig's items (axes: forward, left, up) in the camera's frame
};
/// Returns the places in the start posture of `start`.
Mounting mounting(const scenario::Scenario& scenario, const controllers::Controller& start,
                  const physics::Models& models);

/// The noise of the readings that stabilizer and leg odometry get (scenario: stabilizer).
class FeltNoise {
 public:
  FeltNoise(const walking::StabilizerOptions& options, std::uint64_t seed)
      : options_(options), gyro_(seed, "felt gyro noise"), accelerometer_(seed, "felt accelerometer noise") {}
  void add(walking::SensorReadings& readings);

 private:
  const walking::StabilizerOptions& options_;
  sensor_errors::Random gyro_, accelerometer_;
};

/// Returns the setup of a recording. X_WC_start: as known to the robot.
recording::RecordingSetup recording_setup(const scenario::Scenario& scenario, const walking::Robot& robot,
                                          const Mounting& mounting, const Eigen::Isometry3d& X_WC_start);

}  // namespace sim::live
