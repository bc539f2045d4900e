#include "sim/physics/walking_robot.h"

#include <cmath>
#include <utility>

namespace sim::physics {
namespace {

// At rest: for kRest, gravity and the chest's specific force have differed by less than kRestForce, and its
// gyro has read less than kRestRate. A robot that keeps moving starts as it is.
constexpr double kRestForce = 0.05;  // m/s²; standing robots stay within 0.01
constexpr double kRestRate = 0.01;   // rad/s
constexpr double kRaised = 0.03;     // m, start height of a base that is lowered, and how far it may sag
constexpr double kCarried = 0.8;     // fraction of the weight on the feet at which the base is released
constexpr std::chrono::milliseconds kRest{200}, kLongestSettling{3000};

WorldOptions without_pushes(WorldOptions options) {
  options.pushes.clear();
  return options;
}

}  // namespace

WalkingRobot::WalkingRobot(std::unique_ptr<controllers::Controller> controller, const WorldOptions& options,
                           const PlantVariation& draw, const Models& models, const Eigen::Isometry3d& X_WP,
                           walking::LegOdometry* legs)
    : controller_(std::move(controller)),
      world_(without_pushes(options), draw, controller_->start(), X_WP * controller_->reference().X_PB,
             models) {
  if (!controller_->has_plan()) world_.let_feet_touch();
  if (controller_->held_s() > 0)
    lower(controller_->has_plan() ? nullptr : legs);
  else if (controller_->stands())
    settle();
  if (!controller_->has_plan()) controller_->start_at(walking::on_floor(world_.X_WB()));
  world_.start_clock(options.pushes);
}

WalkingRobot::WalkingRobot(walking::PatternGenerator plan, const walking::StabilizerOptions& stabilizer,
                           const WorldOptions& options, const PlantVariation& draw, const Models& models,
                           const Eigen::Isometry3d& X_WP)
    : WalkingRobot(std::make_unique<controllers::PlanController>(std::move(plan), stabilizer), options, draw,
                   models, X_WP) {}

void WalkingRobot::lower(walking::LegOdometry* legs) {
  const std::chrono::duration<double> held(controller_->held_s());
  const Eigen::Isometry3d X_WB = world_.X_WB();
  bool is_held = true;
  const auto readings = [&] {
    const walking::SensorReadings now = world_.sensor_readings();
    if (legs && !is_held) legs->add(now);
    return now;
  };
  while (is_ok() && world_.time() < 2 * held) {
    if (is_held) {
      const double above = kRaised * (1 - 2 * (world_.time() / held));
      const Eigen::Isometry3d X_WB_held = Eigen::Translation3d(0, 0, above) * X_WB;
      const auto [left, right] = world_.sole_contacts_since_last();
      is_held = world_.time() < held && left.load + right.load < kCarried * world_.weight();
      is_held ? world_.hold(X_WB_held) : world_.release();
      if (!is_held && legs) legs->start_at(X_WB_held);
    }
    command(readings(), true);
    step();
  }
  readings();
}

void WalkingRobot::settle() {
  std::chrono::nanoseconds rest{0};
  while (is_ok() && rest < kRest && world_.time() < kLongestSettling) {
    const walking::SensorReadings readings = world_.sensor_readings();
    const bool at_rest = std::abs(readings.accelerometer.norm() - walking::kGravity) < kRestForce &&
                         readings.gyro.norm() < kRestRate;
    rest = at_rest ? rest + walking::kTick : std::chrono::nanoseconds(0);
    command(readings, true);
    step();
  }
}

void WalkingRobot::command(const walking::SensorReadings& readings, bool settles) {
  try {
    world_.command(controller_->command({readings, world_.velocities(), world_.torques()}, settles));
  } catch (const programs::ProgramFailed& failure) {
    failure_ = failure;
  }
}

void WalkingRobot::step() {
  for (const auto end = world_.time() + walking::kTick; is_ok() && world_.time() < end;) world_.step();
}

void WalkingRobot::tick(walking::LegOdometry* legs,
                        const std::function<void(walking::SensorReadings&)>& disturb) {
  walking::SensorReadings readings = world_.sensor_readings();
  if (disturb) disturb(readings);
  if (legs) legs->add(readings);
  command(readings);
  step();
  if (legs && is_ok()) steer(*legs);
  advance();
}

void WalkingRobot::steer(const walking::LegOdometry& legs) {
  const auto tick = static_cast<std::size_t>(world_.time() / walking::kTick);
  if (!controller_->steers(tick)) return;
  const Eigen::Isometry3d X_OB = legs.motion(world_.leg_readings().q, walking::kPeriod).X_OB;
  controller_->steer(tick, walking::place_by_legs(X_OB, following(), controller_->has_plan()));
}

}  // namespace sim::physics
