#include "sim/live/setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <variant>

#include "sim/camera/lens.h"
#include "sim/camera/shapes.h"
#include "sim/physics/arrangement.h"
#include "sim/physics/clearance.h"
#include "sim/physics/nominal_body.h"
#include "sim/result/limits.h"
#include "sim/scenario/robot.h"
#include "sim/sensor_errors/random.h"

namespace sim::live {
namespace {

constexpr int kFloorWaves = 8;
constexpr double kShortestWave = 1.0, kLongestWave = 4.0;  // m

Eigen::VectorXd normals(std::uint64_t seed, std::string_view stream, double sigma, int count) {
  sensor_errors::Random random(seed, stream);
  Eigen::VectorXd values(count);
  for (double& value : values) value = sigma * random.normal();
  return values;
}

/// Factors around 1, never near 0.
Eigen::VectorXd scales(std::uint64_t seed, std::string_view stream, double sigma, int count) {
  return (normals(seed, stream, sigma, count).array() + 1).max(0.1);
}

/// Returns waves in every direction and of every length, all of the same size.
std::vector<physics::FloorWave> floor(std::uint64_t seed, double sigma) {
  std::vector<physics::FloorWave> waves;
  if (sigma == 0) return waves;
  sensor_errors::Random random(seed, "floor height");
  for (int i = 0; i < kFloorWaves; ++i) {
    const double length = kShortestWave * std::pow(kLongestWave / kShortestWave, random.uniform());
    const double direction = 2 * std::numbers::pi * random.uniform();
    const double k = 2 * std::numbers::pi / length, phase = 2 * std::numbers::pi * random.uniform();
    waves.push_back(
        {sigma * std::sqrt(2.0 / kFloorWaves), {k * std::cos(direction), k * std::sin(direction)}, phase});
  }
  return waves;
}

}  // namespace

walking::PatternGenerator clear_plan(const scenario::ReadScenario& read, const physics::Models& models,
                                     bool slopes) {
  const scenario::Scenario& s = read.scenario;
  walking::PatternGenerator plan(models.robot, s.walk, physics::nominal_body(copy_of(models.on_floor)));
  const auto place = [&](int number) -> std::pair<scenario::Yaml, std::string> {
    const auto command = static_cast<std::size_t>(number);
    const auto word = std::visit([](const auto& c) { return c.kName; }, s.walk.commands[command]);
    scenario::Yaml at = scenario::place_of(read, "");
    if (command < read.command_origins.size()) at.origin = read.command_origins[command];
    return {at, fmt::format("walk.commands[{}]: {}", command, word)};
  };
  if (slopes && result::is_allowed(s, scenario::Ending::fell)) return plan;
  if (const auto step = physics::first_uneven_step(plan, models.on_floor, slopes))
    fail(place(step->command).first, place(step->command).second,
         fmt::format("at {:.2f} s the {} sole is planned onto {} at ({:.2f}, {:.2f}, {:.3f}) m of world.room "
                     "{}; expected {}",
                     step->t_s, step->left ? "left" : "right",
                     step->geom.empty() ? "a shape" : fmt::format("'{}'", step->geom), step->p_W.x(),
                     step->p_W.y(), step->p_W.z(), s.world.room,
                     slopes
                         ? fmt::format("slopes of at most {} deg and edges of at most {} m for a controller "
                                       "that follows slopes, or limits.ending with fell",
                                       physics::kSteepest_deg, physics::kHighestEdge_m)
                         : "a floor at z = 0 under each footstep of the pattern generator"));
  if (slopes) return plan;
  if (result::is_allowed(s, scenario::Ending::collided)) return plan;
  const auto found = physics::first_collision(plan, copy_of(models.in_room));
  if (!found) return plan;
  const Eigen::Vector3d& p = found->p_W;
  fail(place(found->command).first, place(found->command).second,
       fmt::format(
           "at {:.2f} s the planned {} is within {} m of {}, at ({:.2f}, {:.2f}, {:.2f}) m in world.room "
           "{}; expected a walk that keeps clear, or limits.ending with collided",
           found->t_s, found->link, physics::kPlannedMargin_m, found->object, p.x(), p.y(), p.z(),
           s.world.room));
}

std::unique_ptr<controllers::ProgramController> program_controller(const scenario::ReadScenario& read,
                                                                   const physics::Models& models) {
  const scenario::Scenario& scenario = read.scenario;
  scenario::Scenario walk;
  walk.walk = scenario.walk;
  walk.walk.steering.by = walking::SteeredBy::plan;  // only the bench estimates
  walk.stabilizer = scenario.stabilizer;
  walk.world.robot = scenario.world.robot;
  const scenario::ControllerTime& time = scenario.controller_time;
  controllers::ProgramStart start{scenario.controller,
                                  models.robot,
                                  physics::describe(models, scenario::read_robot(scenario)),
                                  scenario::to_yaml(walk, {"walk.", "stabilizer.", "world.robot"}),
                                  scenario.walk,
                                  scenario.seed,
                                  scenario.stabilizer.attitude,
                                  {1e-3 * time.answer_ms, time.model == scenario::TimeModel::measured}};
  try {
    auto controller = std::make_unique<controllers::ProgramController>(std::move(start));
    if (controller->plans_on_slopes()) clear_plan(read, models, true);
    return controller;
  } catch (const programs::ProgramFailed& failure) {
    throw std::invalid_argument(failure.what());
  }
}

physics::PlantVariation plant_variation(std::uint64_t seed, const physics::WorldOptions& world, int joints) {
  const int links = joints + 1;
  const physics::WorldOptions::Variation& spread = world.variation;
  physics::PlantVariation drawn;
  drawn.floor_friction =
      std::max(0.01, world.floor_friction + normals(seed, "floor friction", spread.friction, 1)[0]);
  drawn.joint_offset_rad = normals(seed, "joint zeros", spread.joint_offset_rad, joints);
  drawn.mass_scale = scales(seed, "link masses", spread.mass_fraction, links);
  // The names of random streams are part of every recording, so this one keeps its British spelling.
  drawn.com_offset_m = normals(seed, "centres of mass", spread.com_m, 3 * links).reshaped(3, links);
  drawn.posture_rad = normals(seed, "posture at the start", spread.posture_rad, joints);
  drawn.servo_scale = scales(seed, "servo gains", spread.servo_fraction, joints);
  drawn.floor = floor(seed, spread.floor_height_m);
  return drawn;
}

void arrange(const scenario::ReadScenario& read, physics::Models& models) {
  const physics::WorldOptions& world = read.scenario.world;
  physics::arrange(*models.on_floor, world, read.scenario.walk);
  if (physics::arrange(*models.in_room, world, read.scenario.walk) == 0 && world.moved.seed != 0)
    fail(scenario::place_of(read, "world.moved"), "world.moved",
         fmt::format(
             "nothing was moved: world.room {} has no furniture with space around it, expected bodies that "
             "stand on the floor and touch nothing else",
             world.room));
}

void mount_sensors(const scenario::ReadScenario& read, physics::Models& models) {
  const scenario::Scenario& s = read.scenario;
  const char* key = "camera.link";
  try {
    models.mount(s.camera.value_or(camera::CameraOptions{}), {});
    key = "imu.link";
    models.mount({}, s.imu);
    key = "rig";
    places(s.rig, *models.on_floor);
  } catch (const std::invalid_argument& problem) {
    fail(scenario::place_of(read, key), key, problem.what());
  }
}

std::vector<physics::Place> places(const std::vector<rig::Item>& rig, const mjModel_& model) {
  std::vector<physics::Place> all;
  for (const rig::Item& item : rig)
    all.push_back(std::visit(
        [&](const auto& sensor) {
          if constexpr (std::is_base_of_v<rig::Mount, std::decay_t<decltype(sensor)>>)
            return physics::place_of(model, sensor);
          else
            return physics::place_of(model, rig::Mount{});
        },
        item));
  return all;
}

Mounting mounting(const scenario::Scenario& scenario, const controllers::Controller& start,
                  const physics::Models& models) {
  physics::WorldOptions empty = scenario.world;
  empty.room = physics::kPhysicalRoom;
  const physics::World nominal(empty, {}, start.start(), start.reference().X_PB, models);
  const Eigen::Isometry3d X_CW = nominal.X_WC().inverse();
  Mounting mounting{nominal.X_WB().inverse() * nominal.X_WC(), X_CW * nominal.X_WG(), {}};
  for (const physics::Place& place : places(scenario.rig, *models.on_floor))
    mounting.X_CL.push_back(X_CW * nominal.X_W(place));
  return mounting;
}

recording::RecordingSetup recording_setup(const scenario::Scenario& scenario, const walking::Robot& robot,
                                          const Mounting& mounting, const Eigen::Isometry3d& X_WC_start) {
  const camera::CameraOptions camera = scenario.camera.value_or(camera::CameraOptions{});
  recording::RecordingSetup setup;
  setup.calibration = {camera::camera_model(camera), mounting.X_CG};
  setup.X_WC_start = X_WC_start;
  setup.camera_rate_hz = camera.rate_hz;
  for (const walking::Joint& joint : robot.joints) setup.joints.push_back(joint.name);
  setup.rig = rig::calibrated(scenario.rig, setup.calibration.camera, camera.rate_hz, camera.readout_s,
                              mounting.X_CL);
  return setup;
}

void FeltNoise::add(walking::SensorReadings& readings) {
  const auto normal = [](sensor_errors::Random& random, double sigma) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, z));
  };
  readings.gyro += normal(gyro_, options_.gyro_sigma_rad_s);
  readings.accelerometer += normal(accelerometer_, options_.accelerometer_sigma_m_s2);
}

}  // namespace sim::live
