#include "sim/live/recorded.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <type_traits>
#include <variant>

#include "sim/physics/clearance.h"
#include "sim/physics/nominal_body.h"
#include "sim/result/limits.h"
#include "sim/sensor_errors/random.h"
#include "walking/kinematics.h"
#include "walking/plan.h"

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

/// Waves of every direction and length, of the same size each.
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

slam::Support support(walking::Support s) {
  if (s == walking::Support::both) return slam::Support::both;
  return s == walking::Support::left ? slam::Support::left : slam::Support::right;
}

Eigen::Vector3d support_sole(const walking::Reference& reference) {
  const Eigen::Vector3d left = reference.X_PL.translation(), right = reference.X_PR.translation();
  if (reference.support == walking::Support::both) return (left + right) / 2;
  return reference.support == walking::Support::left ? left : right;
}

Eigen::Vector3d on_ground(const Eigen::Isometry3d& X) {
  return {X.translation().x(), X.translation().y(), std::atan2(X.linear()(1, 0), X.linear()(0, 0))};
}

Eigen::Vector3d planar(const walking::FootPose& pose) {
  return {pose.position.x(), pose.position.y(), pose.yaw};
}

recording::TrueFoot true_foot(const Eigen::Isometry3d& X_WS, const Eigen::Isometry3d& X_PS, bool planned_down,
                              const physics::SoleContact& contact) {
  return {on_ground(X_WS), on_ground(X_PS), planned_down, contact.load,
          Eigen::Vector3d(contact.creep.x(), contact.creep.y(), contact.creep_yaw)};
}

}  // namespace

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
    scenario::Yaml at;  // scenarios that were not read from text only have a name
    at.origin.file = s.name;
    if (const auto place = read.places.find(key); place != read.places.end()) at.origin = place->second;
    fail(at, key, problem.what());
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

RigImus::RigImus(const std::vector<rig::Item>& rig, const std::vector<physics::Place>& places,
                 const physics::World& world) {
  for (std::size_t i = 0; i < rig.size(); ++i)
    if (const auto* imu = std::get_if<rig::Imu>(&rig[i]))
      imus_.push_back({static_cast<int>(i), places[i],
                       std::chrono::milliseconds(std::llround(1e3 / imu->rate_hz)),
                       world.imu_state(places[i])});
}

void RigImus::read(const physics::World& world, std::vector<slam::RigReading>& readings) {
  for (Imu& imu : imus_) {
    if (world.time() < imu.last.t + imu.period) continue;
    const physics::ImuState now = world.imu_state(imu.place);
    const physics::ImuReading reading = physics::reading_between(imu.last, now, world.gravity());
    slam::RigReading& added = readings.emplace_back();
    added.sensor = imu.sensor;
    added.begin = reading.begin, added.t = reading.end;
    added.gyro = reading.gyro, added.accelerometer = reading.specific_force;
    imu.last = now;
  }
}

walking::PatternGenerator clear_plan(const scenario::ReadScenario& read, const physics::Models& models) {
  const scenario::Scenario& s = read.scenario;
  walking::PatternGenerator plan(s.walk, physics::nominal_body(copy_of(models.on_floor)));
  if (result::is_allowed(s, scenario::Ending::collided)) return plan;
  const auto found = physics::first_collision(plan, copy_of(models.in_room));
  if (!found) return plan;
  const auto command = static_cast<std::size_t>(found->command);
  const auto word = std::visit([](const auto& c) { return c.kName; }, s.walk.commands[command]);
  const Eigen::Vector3d& p = found->p_W;
  scenario::Yaml at;  // scenarios that were not read from text only have a name
  at.origin.file = s.name;
  if (command < read.command_origins.size()) at.origin = read.command_origins[command];
  fail(at, fmt::format("walk.commands[{}]: {}", command, word),
       fmt::format(
           "at {:.2f} s the planned {} is within {} m of {}, at ({:.2f}, {:.2f}, {:.2f}) m in world.room "
           "{}; expected a walk clear of it, or limits.ending with collided",
           found->t_s, found->link, physics::kPlannedMargin_m, found->object, p.x(), p.y(), p.z(),
           s.world.room));
}

physics::PlantVariation plant_variation(std::uint64_t seed, const physics::WorldOptions& world) {
  constexpr int kJoints = walking::kJoints, kLinks = kJoints + 1;
  const physics::WorldOptions::Variation& spread = world.variation;
  physics::PlantVariation drawn;
  drawn.floor_friction =
      std::max(0.01, world.floor_friction + normals(seed, "floor friction", spread.friction, 1)[0]);
  drawn.joint_offset_rad = normals(seed, "joint zeros", spread.joint_offset_rad, kJoints);
  drawn.mass_scale = scales(seed, "link masses", spread.mass_fraction, kLinks);
  // The name of a random stream is part of every recording: British spelling stays here.
  drawn.com_offset_m = normals(seed, "centres of mass", spread.com_m, 3 * kLinks).reshaped(3, kLinks);
  drawn.posture_rad = normals(seed, "posture at the start", spread.posture_rad, kJoints);
  drawn.servo_scale = scales(seed, "servo gains", spread.servo_fraction, kJoints);
  drawn.floor = floor(seed, spread.floor_height_m);
  return drawn;
}

Eigen::Isometry3d planned_waist(const walking::Reference& from, const walking::Reference& to, double t_s) {
  const double part = (t_s - from.t_s) / walking::kPeriod;
  Eigen::Isometry3d X_PB;
  X_PB.linear() =
      Eigen::Quaterniond(from.X_PB.linear()).slerp(part, Eigen::Quaterniond(to.X_PB.linear())).matrix();
  X_PB.translation() = (1 - part) * from.X_PB.translation() + part * to.X_PB.translation();
  X_PB.makeAffine();
  return X_PB;
}

slam::PlannedMotion planned_motion(const walking::Reference& from, const walking::Reference& to, double t_s,
                                   const Eigen::Isometry3d& X_BC) {
  slam::PlannedMotion motion;
  motion.X_PC = planned_waist(from, to, t_s) * X_BC;
  const Eigen::Matrix3d R_CP = motion.X_PC.linear().transpose();
  const Eigen::Vector3d w_PB_P = from.waist_yaw_rate * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d p_BC_P = from.X_PB.linear() * X_BC.translation();
  motion.v_PC_C = R_CP * (from.waist_velocity + w_PB_P.cross(p_BC_P));
  motion.w_PC_C = R_CP * w_PB_P;
  motion.support = support(from.support);
  motion.p_CF = motion.X_PC.inverse() * support_sole(from);
  return motion;
}

Mounting mounting(const scenario::Scenario& scenario, const walking::Reference& start,
                  const physics::Models& models) {
  const walking::JointVector q = walking::inverse_kinematics(start).q;
  physics::WorldOptions empty = scenario.world;
  empty.room = physics::kPhysicalRoom;
  const physics::World nominal(empty, {}, q, start.X_PB, models);
  const Eigen::Isometry3d X_CW = nominal.X_WC().inverse();
  Mounting mounting{nominal.X_WB().inverse() * nominal.X_WC(), X_CW * nominal.X_WG(), {}};
  for (const physics::Place& place : places(scenario.rig, *models.on_floor))
    mounting.X_CL.push_back(X_CW * nominal.X_W(place));
  return mounting;
}

recording::RecordingSetup recording_setup(const scenario::Scenario& scenario, const Mounting& mounting,
                                          const Eigen::Isometry3d& X_PB) {
  const camera::CameraOptions camera = scenario.camera.value_or(camera::CameraOptions{});
  recording::RecordingSetup setup;
  setup.calibration = {camera::camera_model(camera), mounting.X_CG};
  setup.X_WC_start = X_PB * mounting.X_BC;
  setup.camera_rate_hz = camera.rate_hz;
  setup.joints = physics::joint_names();
  setup.rig = rig::calibrated(scenario.rig, setup.calibration.camera, camera.rate_hz, camera.readout_s,
                              mounting.X_CL);
  return setup;
}

std::vector<score::StepCorrection> recorded(const std::vector<walking::StepCorrection>& corrections) {
  std::vector<score::StepCorrection> steps;
  for (const walking::StepCorrection& c : corrections)
    steps.push_back({std::chrono::nanoseconds(std::llround(1e9 * c.decided_s)), c.correction.position.x(),
                     c.correction.position.y(), c.correction.yaw, c.desired.side == walking::Side::left,
                     planar(c.desired.pose), planar(c.expected)});
  return steps;
}

slam::BodyReading recorded(std::chrono::nanoseconds t, const walking::SensorReadings& readings) {
  const auto wrench = [](const walking::Wrench& w) { return slam::BodyReading::Wrench{w.force, w.torque}; };
  return {t, readings.q, wrench(readings.left), wrench(readings.right)};
}

recording::TrueMotion true_motion(const physics::World& world) {
  return {world.time(), world.X_WG(), world.v_WG()};
}

recording::TrueFeet true_feet(physics::World& world, const walking::Reference& plan) {
  const auto [left, right] = world.sole_contacts_since_last();
  return {world.time(), true_foot(world.X_WL(), plan.X_PL, plan.support != walking::Support::right, left),
          true_foot(world.X_WR(), plan.X_PR, plan.support != walking::Support::left, right)};
}

scenario::Ending ending(physics::Condition condition) {
  using enum scenario::Ending;
  constexpr std::array kEndings{completed, fell, collided, failed};  // in the order of the conditions
  return kEndings[static_cast<std::size_t>(condition)];
}

}  // namespace sim::live
