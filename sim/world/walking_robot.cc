#include "sim/world/walking_robot.h"

#include <utility>

#include "walking/inverse_kinematics.h"

namespace sim::world {

WalkingRobot::WalkingRobot(walking::PatternGenerator plan, const walking::StabilizerOptions& stabilizer,
                           const WorldOptions& options, const Draw& draw, const std::filesystem::path& models,
                           const Eigen::Isometry3d& X_WP)
    : plan_(std::move(plan)),
      stabilizer_(stabilizer),
      q_(walking::inverse_kinematics(walking::posture_of(reference_)).q),
      world_(options, draw, q_, X_WP * reference_.X_PB, models) {}

void WalkingRobot::command(const walking::SensorReadings& readings) {
  const walking::Posture posture = stabilizer_.step(reference_, readings);
  const walking::JointVector q = walking::inverse_kinematics(posture).q;
  world_.command(q, (q - q_) / walking::kPeriod);
  q_ = q;
}

void WalkingRobot::advance() {
  reference_ = std::exchange(following_, plan_.next());
  ++tick_;
}

void WalkingRobot::tick() {
  command(world_.sensor_readings());
  for (const auto end = world_.time() + walking::kTick; is_ok() && world_.time() < end;) world_.step();
  advance();
}

}  // namespace sim::world
