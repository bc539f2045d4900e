#include "sim/live/mounting.h"

#include <cmath>
#include <type_traits>
#include <variant>

#include "sim/camera/lens.h"
#include "walking/kinematics.h"

namespace sim::live {

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

}  // namespace sim::live
