// A result folder with the recording of a walk in the synthetic room, which is all that trials need;
// no simulator.
#pragma once

#include "sim/recording/recording.h"
#include "tests/slam/synthetic_room.h"

namespace tests {

/// A walk along part of the circle with that many frames.
inline slam::synthetic::Walk short_walk(int frames) {
  slam::synthetic::Walk walk;
  walk.duration_s = (frames - 1) / walk.rate_hz + 1e-3;
  walk.turns = walk.duration_s / 28;
  walk.stand_s = 0.2;
  return walk;
}

/// Writes folder/{scenario.yaml,about.json,recording/} of the walk with ideal sensors; `text` goes into the
/// scenario. readings: the rig's at a frame.
inline void write_result(
    const std::filesystem::path& folder, const slam::synthetic::Walk& walk, const std::string& text = "",
    const std::vector<sim::rig::RigSensor>& rig = {},
    const std::function<std::vector<slam::RigReading>(int frame, slam::Stamp t)>& readings = {}) {
  namespace synthetic = slam::synthetic;
  synthetic::Walk ideal = walk;
  ideal.gyro_sigma_rad_s = ideal.accelerometer_sigma_m_s2 = ideal.image_sigma = 0;
  const synthetic::Recording recording(ideal, render(synthetic::Room(), walk));
  std::filesystem::create_directories(folder);
  sim::recording::RecordingSetup setup;
  setup.calibration = synthetic::calibration();
  setup.X_WC_start = ideal.X_WC(0);
  setup.rig = rig;
  sim::recording::RecordingWriter writer(folder / "recording", setup);
  for (int k = 0; k < ideal.frames(); ++k) {
    slam::Observation o = recording.observation(k);
    if (readings) o.rig = readings(k, o.t);
    writer.add(o);
    writer.add(sim::recording::TruePoses{o.t, ideal.X_WC(slam::seconds(o.t)), ideal.X_WC(slam::seconds(o.t)),
                                         o.plan->X_PC});
  }
  sim::score::Surface walls{
      sim::score::Surface::Kind::box, Eigen::Isometry3d::Identity(), {3.5, 5.5, 1.5}};  // as it is rendered
  walls.X_WS.translation() << 0.1, 0.7, 1.5;
  writer.add(walls);
  writer.finish();
  std::ofstream(folder / "scenario.yaml")
      << "name: synthetic\nwalk: {commands: [{stand: {duration_s: " << ideal.duration_s
      << "}}]}\ncamera: {}\nslam: {}\n" + text;
  std::ofstream(folder / "about.json") << R"({"walk_ending": "completed"})";
}

}  // namespace tests
