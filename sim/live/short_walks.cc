#include "sim/live/short_walks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/live/setup.h"
#include "sim/physics/nominal_body.h"
#include "sim/physics/walking_robot.h"
#include "sim/score/trajectory.h"
#include "walking/kinematics.h"

namespace sim::live {
namespace {

constexpr double kWalk_s = 8;
constexpr int kFrameTicks = 7;  // about the time between two frames of a camera
constexpr double kYaw_rad = 15 * score::kDegree, kShare = 0.1, kLeast_m = 0.05;

/// Counts how often a foot has left the floor and landed.
class Landings {
 public:
  void add(double height_m) {
    if (height_m < kLanded_m && std::exchange(is_up_, false)) ++count_;
    is_up_ |= height_m > kLifted_m;
  }
  int count() const { return count_; }

 private:
  static constexpr double kLifted_m = 0.005, kLanded_m = 0.0025;
  bool is_up_ = false;
  int count_ = 0;
};

/// Sums up how far soles move from where they stood when they began to carry the robot alone.
class Slip {
 public:
  void add(walking::Support support, const physics::World& world) {
    const Eigen::Vector3d sole =
        (support == walking::Support::left ? world.X_WL() : world.X_WR()).translation();
    if (support != support_) sum_m_ += (last_ - first_).head<2>().norm(), first_ = sole;
    support_ = support;
    last_ = support == walking::Support::both ? first_ : sole;
  }
  double sum_m() const { return sum_m_; }

 private:
  walking::Support support_ = walking::Support::both;
  Eigen::Vector3d first_ = Eigen::Vector3d::Zero(), last_ = first_;
  double sum_m_ = 0;
};

}  // namespace

std::vector<ShortWalk> short_walks(const walking::WalkOptions& options) {
  const double steps =
      std::max(2.0, std::floor(kWalk_s / (options.single_support_s + options.double_support_s)));
  const double ahead = (steps - 1) * options.step_length_m,
               aside = std::floor(steps / 2) * options.step_length_m,
               turn = (steps - 1) * walking::Turn{}.step_rad;
  const auto walk = [](const char* name, const walking::Command& command) {
    return ShortWalk{name, {walking::Stand{0.5}, command, walking::Stand{1}}};
  };
  return {
      walk("ahead", walking::Straight{ahead, 0}),       walk("back", walking::Straight{-ahead, 0}),
      walk("to the left", walking::Straight{0, aside}), walk("to the right", walking::Straight{0, -aside}),
      walk("turning left", walking::Turn{turn}),        walk("turning right", walking::Turn{-turn})};
}

std::string Walked::complaint() const {
  if (!problem.empty()) return problem;
  if (yaw_error_rad <= kYaw_rad && error_m <= std::max(kLeast_m, kShare * path_m)) return "";
  return fmt::format("ends {:.2f} m and {:.0f} deg from the end of its path of {:.2f} m", error_m,
                     yaw_error_rad / score::kDegree, path_m);
}

Walked walked(const scenario::Scenario& scenario, const physics::Models& models,
              std::vector<walking::Command> commands, std::optional<std::uint64_t> seed) try {
  walking::WalkOptions walk = scenario.walk;
  walk.commands = std::move(commands);
  walking::PatternGenerator plan(models.robot, walk, physics::nominal_body(copy_of(models.on_floor)));
  physics::WorldOptions world = scenario.world;
  if (!seed) world.variation = {0, 0, 0, 0, 0, 0, 0};
  if (walk.steering.by != walking::SteeredBy::legs) walk.steering.by = walking::SteeredBy::plan;
  physics::WalkingRobot robot(
      std::make_unique<controllers::PlanController>(std::move(plan), scenario.stabilizer, walk.steering),
      world, plant_variation(seed.value_or(1), world, int(models.robot.joints.size())), models);
  const Eigen::Isometry3d start = robot.reference().X_PB;
  std::array<Landings, 2> landings;
  Slip slip;
  const Eigen::Isometry3d X_BC = mounting(scenario, robot.controller(), models).X_BC;
  walking::LegOdometry legs(models.robot, start);
  legs.add(robot.world().leg_readings());
  FeltNoise noise(scenario.stabilizer, seed.value_or(1));
  Walked result;
  result.noises.start(start * X_BC, robot.world().X_WC());
  const double floor[]{robot.world().X_WL().translation().z(), robot.world().X_WR().translation().z()};
  int ticks = 0, limited = 0;
  for (; robot.walks(); ++ticks) {
    slip.add(robot.reference().support, robot.world());
    robot.tick(&legs, [&](walking::SensorReadings& readings) { noise.add(readings); });
    limited += robot.world().torque_limited_since_last().value_or(false);
    landings[0].add(robot.world().X_WL().translation().z() - floor[0]);
    landings[1].add(robot.world().X_WR().translation().z() - floor[1]);
    if (ticks % kFrameTicks == 0)
      result.noises.add(legs.motion(robot.world().leg_readings().q, walking::kPeriod).X_OB *
                            robot.world().mounts_by_encoders().X_BC,
                        robot.world().X_WC(), kFrameTicks * walking::kPeriod);
  }
  if (robot.is_ok()) result.noises.end(2 * (walk.single_support_s + walk.double_support_s));
  const physics::Status& status = robot.world().status();
  if (!robot.is_ok())
    result.problem = status.condition == physics::Condition::fell ? "fell " + status.cause : status.cause;
  result.lasted = robot.progress();
  result.landings = {landings[0].count(), landings[1].count()};
  result.limited = double(limited) / std::max(1, ticks);
  Eigen::Isometry3d end = robot.reference().X_PB;
  end.translation().head<2>() -= robot.reference().frame_shift;
  if (const auto path = robot.controller().path()) end = path->now.X_PB;
  const Eigen::Isometry3d X_WB = robot.world().X_WB();
  result.path_m = (end.translation() - start.translation()).head<2>().norm();
  result.error_m = (X_WB.translation() - end.translation()).head<2>().norm();
  const auto turn = [](const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
    return std::abs(
        std::remainder(walking::on_floor(to).yaw - walking::on_floor(from).yaw, 2 * std::numbers::pi));
  };
  result.turn_rad = turn(start, end);
  result.yaw_error_rad = turn(end, X_WB);
  result.slip_m = slip.sum_m();
  return result;
} catch (const std::invalid_argument& e) {
  return {.problem = e.what()};
}

}  // namespace sim::live
