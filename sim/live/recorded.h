// The checked plan of a run, and conversion between scenario, simulator, plan and recording.
#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/camera/lens.h"
#include "sim/physics/options.h"
#include "sim/physics/world.h"
#include "sim/recording/recording.h"
#include "sim/rig/rig.h"
#include "sim/scenario/scenario.h"
#include "slam/observation.h"
#include "walking/pattern_generator.h"
#include "walking/plan.h"
#include "walking/stabilizer.h"
#include "walking/steering.h"

namespace sim::live {

/// Returns the plan of the walk. Throws std::invalid_argument if it cannot be planned, and ConfigError at a
/// walk command with a planned posture too close to a wall or furniture, unless the scenario allows a run to
/// end as "collided".
walking::PatternGenerator clear_plan(const scenario::ReadScenario& read, const physics::Models& models);

/// Moves head camera and chest IMU of the models to the scenario's mounts. Throws ConfigError if a link does
/// not exist, also of the rig.
void mount_sensors(const scenario::ReadScenario& read, physics::Models& models);

/// Returns the places of a scenario's rig items on the robot; a depth camera's is the head camera's.
std::vector<physics::Place> places(const std::vector<rig::Item>& rig, const mjModel_& model);

/// The further IMUs: read at each of their periods.
class RigImus {
 public:
  RigImus(const std::vector<rig::Item>& rig, const std::vector<physics::Place>& places,
          const physics::World& world);
  /// Appends the readings that end now. Must be called at each millisecond.
  void read(const physics::World& world, std::vector<slam::RigReading>& readings);

 private:
  struct Imu {
    int sensor;
    physics::Place place;
    std::chrono::nanoseconds period;
    physics::ImuState last;
  };
  std::vector<Imu> imus_;
};

/// Returns the variations, each from its own named stream, so a spread of 0 does not change the others.
physics::PlantVariation plant_variation(std::uint64_t seed, const physics::WorldOptions& world);

/// Returns the waist pose X_PB at time t (s), from.t_s <= t <= to.t_s: position and yaw linear between the
/// two references (one control period apart; as the plan accelerates by at most a few m/s², the error is
/// below 20 µm).
Eigen::Isometry3d planned_waist(const walking::Reference& from, const walking::Reference& to, double t_s);

/// Returns the planned motion of a camera fixed to the waist at X_BC. Velocities: those of the tick before t.
slam::PlannedMotion planned_motion(const walking::Reference& from, const walking::Reference& to, double t_s,
                                   const Eigen::Isometry3d& X_BC);

/// The mounting of head camera and chest IMU on the robot in its planned posture, by the nominal model.
struct Mounting {
  Eigen::Isometry3d X_BC, X_CG;
  std::vector<Eigen::Isometry3d> X_CL;  ///< axes forward, left, up of the rig's items in the camera's frame
};
Mounting mounting(const scenario::Scenario& scenario, const walking::Reference& start,
                  const physics::Models& models);

/// Returns the setup of a recording. X_PB: the planned waist at the start.
recording::RecordingSetup recording_setup(const scenario::Scenario& scenario, const Mounting& mounting,
                                          const Eigen::Isometry3d& X_PB);

std::vector<score::StepCorrection> recorded(const std::vector<walking::StepCorrection>& corrections);
slam::BodyReading recorded(std::chrono::nanoseconds t, const walking::SensorReadings& readings);

/// Returns the true motion of the chest IMU at the world's time.
recording::TrueMotion true_motion(const physics::World& world);

/// Returns both feet, true and as planned. Load and creep are those since the last call.
recording::TrueFeet true_feet(physics::World& world, const walking::Reference& plan);

/// Returns how a walk ended.
scenario::Ending ending(physics::Condition condition);

}  // namespace sim::live
