#include "sim/physics/walking_robot.h"

#include <cmath>
#include <utility>

#include "walking/kinematics.h"

namespace sim::physics {
namespace {

// At rest: gravity and the chest's specific force have differed by less than kRestForce, and its gyro has
// read less than kRestRate, for kRest. A robot that keeps moving starts as it is.
constexpr double kRestForce = 0.05;  // m/s²; standing robots stay within 0.01
constexpr double kRestRate = 0.01;   // rad/s
constexpr std::chrono::milliseconds kRest{200}, kLongestSettling{3000};

WorldOptions without_pushes(WorldOptions options) {
  options.pushes.clear();
  return options;
}

}  // namespace

WalkingRobot::WalkingRobot(walking::PatternGenerator plan, const walking::StabilizerOptions& stabilizer,
                           const WorldOptions& options, const PlantVariation& draw, const Models& models,
                           const Eigen::Isometry3d& X_WP)
    : plan_(std::move(plan)),
      adjustment_(models.robot, stabilizer.landing_adjustment),
      stabilizer_(models.robot, stabilizer),
      q_(walking::inverse_kinematics(models.robot, reference_, models.robot.posture).q),
      world_(without_pushes(options), draw, q_, X_WP * reference_.X_PB, models) {
  settle();
  world_.start_clock(options.pushes);
}

void WalkingRobot::settle() {
  std::chrono::nanoseconds rest{0};
  while (is_ok() && rest < kRest && world_.time() < kLongestSettling) {
    const walking::SensorReadings readings = world_.sensor_readings();
    const bool at_rest = std::abs(readings.accelerometer.norm() - walking::kGravity) < kRestForce &&
                         readings.gyro.norm() < kRestRate;
    rest = at_rest ? rest + walking::kTick : std::chrono::nanoseconds(0);
    command(readings);
    step();
  }
}

void WalkingRobot::command(const walking::SensorReadings& readings) {
  adjusted_ = adjustment_.adjust(reference_, stabilizer_.state(), readings);
  const walking::Posture posture = stabilizer_.step(adjusted_, readings);
  const walking::JointVector q = walking::inverse_kinematics(plan_.robot(), posture, q_).q;
  world_.command(q, (q - q_) / walking::kPeriod);
  q_ = q;
}

void WalkingRobot::advance() {
  reference_ = std::exchange(following_, plan_.next());
  adjusted_ = adjustment_.shifted(reference_);
  ++tick_;
}

void WalkingRobot::step() {
  for (const auto end = world_.time() + walking::kTick; is_ok() && world_.time() < end;) world_.step();
}

void WalkingRobot::tick() {
  command(world_.sensor_readings());
  step();
  advance();
}

}  // namespace sim::physics
