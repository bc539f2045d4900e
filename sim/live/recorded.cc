#include "sim/live/recorded.h"

#include <cmath>

#include "walking/kinematics.h"

namespace sim::live {
namespace {

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

slam::CameraIntrinsics intrinsics(const camera::CameraModel& lens) {
  return {lens.width_px,
          lens.height_px,
          lens.fu_px,
          lens.fv_px,
          lens.u0_px,
          lens.v0_px,
          slam::OneParameterRadial{lens.k1_px2}};
}

Mounting mounting(const scenario::Scenario& scenario, const walking::Reference& start,
                  const physics::Models& models) {
  const walking::JointVector q = walking::inverse_kinematics(walking::posture_of(start)).q;
  physics::WorldOptions empty = scenario.world;
  empty.room = physics::kPhysicalRoom;
  const physics::World nominal(empty, {}, q, start.X_PB, models);
  return {nominal.X_WB().inverse() * nominal.X_WC(), nominal.X_WC().inverse() * nominal.X_WG()};
}

recording::RecordingSetup recording_setup(const scenario::Scenario& scenario, const Mounting& mounting,
                                          const Eigen::Isometry3d& X_PB) {
  const camera::CameraOptions camera = scenario.camera.value_or(camera::CameraOptions{});
  recording::RecordingSetup setup;
  setup.calibration = {intrinsics(camera::camera_model(camera)), mounting.X_CG};
  setup.X_WC_start = X_PB * mounting.X_BC;
  setup.camera_rate_hz = camera.rate_hz;
  setup.joints = physics::joint_names();
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

recording::BodyReading recorded(std::chrono::nanoseconds t, const walking::SensorReadings& readings) {
  const auto wrench = [](const walking::Wrench& w) {
    return recording::BodyReading::Wrench{w.force, w.torque};
  };
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
  switch (condition) {
    case physics::Condition::fell:
      return scenario::Ending::fell;
    case physics::Condition::collided:
      return scenario::Ending::collided;
    case physics::Condition::physics_failed:
      return scenario::Ending::failed;
    case physics::Condition::ok:
      break;
  }
  return scenario::Ending::completed;
}

}  // namespace sim::live
