// The simulated world in the terms of a recording.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "sim/camera/lens.h"
#include "sim/physics/world.h"
#include "sim/recording/recording.h"
#include "sim/scenario/scenario.h"
#include "walking/plan.h"
#include "walking/stabilizer.h"
#include "walking/steering.h"

namespace sim::live {

/// The mounting of head camera and chest IMU on the robot in its planned posture, by the nominal model.
struct Mounting {
  Eigen::Isometry3d X_BC, X_CG;
};
Mounting mounting(const scenario::Scenario& scenario, const walking::Reference& start,
                  const physics::Models& models);

/// The simulated camera as estimators are told of it.
slam::CameraIntrinsics intrinsics(const camera::CameraModel& lens);

/// X_PB: the planned waist at the start.
recording::RecordingSetup recording_setup(const scenario::Scenario& scenario, const Mounting& mounting,
                                          const Eigen::Isometry3d& X_PB);

std::vector<score::StepCorrection> recorded(const std::vector<walking::StepCorrection>& corrections);
recording::BodyReading recorded(std::chrono::nanoseconds t, const walking::SensorReadings& readings);

/// True motion of the chest IMU at the world's time.
recording::TrueMotion true_motion(const physics::World& world);

/// Both feet, true and as planned. Load and creep are those since the last call.
recording::TrueFeet true_feet(physics::World& world, const walking::Reference& plan);

/// Returns how a walk ended.
scenario::Ending ending(physics::Condition condition);

}  // namespace sim::live
