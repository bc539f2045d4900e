// Conversion of planned and simulated values to those of a recording.
#pragma once

#include "sim/physics/world.h"
#include "sim/recording/recording.h"
#include "sim/scenario/scenario.h"
#include "slam/observation.h"
#include "walking/plan.h"
#include "walking/stabilizer.h"
#include "walking/steering.h"

namespace sim::live {

/// Returns the waist pose X_PB at time t (s), from.t_s <= t <= to.t_s: position and yaw linear between the
/// two references (one control period apart; as the plan accelerates by at most a few m/s², the error is
/// below 20 µm).
Eigen::Isometry3d planned_waist(const walking::Reference& from, const walking::Reference& to, double t_s);

/// Returns the planned motion of a camera fixed to the waist at X_BC. Velocities: those of the tick before t.
slam::PlannedMotion planned_motion(const walking::Reference& from, const walking::Reference& to, double t_s,
                                   const Eigen::Isometry3d& X_BC);

std::vector<score::StepCorrection> recorded(const std::vector<walking::StepCorrection>& corrections);
slam::BodyReading recorded(std::chrono::nanoseconds t, const walking::SensorReadings& readings);

/// Returns the true motion of the chest IMU at the world's time.
recording::TrueMotion true_motion(const physics::World& world);

/// Returns both feet, true and as planned. Load and creep are those since the last call.
recording::TrueFeet true_feet(physics::World& world, const walking::Reference& plan);

/// Returns how a walk ended.
scenario::Ending ending(physics::Condition condition);

}  // namespace sim::live
