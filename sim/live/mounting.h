// Sensors on the robot: where they are mounted, and the readings of further IMUs.
#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <vector>

#include "sim/physics/world.h"
#include "sim/recording/recording.h"
#include "sim/rig/rig.h"
#include "sim/scenario/scenario.h"
#include "walking/plan.h"

namespace sim::live {

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

}  // namespace sim::live
