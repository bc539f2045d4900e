#include "tests/sim/trials/synthetic_result.h"

#include <fstream>

#include "sim/recording/recording.h"

namespace tests {
namespace {

namespace synthetic = slam::synthetic;

// The room's walls, as the renderer of the synthetic room has them.
sim::score::Surface walls() {
  sim::score::Surface box{sim::score::Surface::Kind::box, Eigen::Isometry3d::Identity(), {3.5, 5.5, 1.5}};
  box.X_WS.translation() << 0.1, 0.7, 1.5;
  return box;
}

}  // namespace

synthetic::Walk short_walk(int frames) {
  synthetic::Walk walk;
  walk.duration_s = (frames - 1) / walk.rate_hz + 1e-3;
  walk.turns = walk.duration_s / 28;
  walk.stand_s = 0.2;
  return walk;
}

void write_result(const std::filesystem::path& folder, const synthetic::Walk& walk, const std::string& text) {
  write_result(folder, walk, render(synthetic::Room(), walk), text);
}

void write_result(const std::filesystem::path& folder, const synthetic::Walk& walk,
                  std::vector<cv::Mat> images, const std::string& text) {
  synthetic::Walk ideal = walk;
  ideal.gyro_sigma_rad_s = ideal.accelerometer_sigma_m_s2 = ideal.image_sigma = 0;
  const synthetic::Recording recording(ideal, std::move(images));
  std::filesystem::create_directories(folder);
  sim::recording::RecordingSetup setup;
  setup.calibration = synthetic::calibration();
  setup.X_WC_start = ideal.X_WC(0);
  sim::recording::RecordingWriter writer(folder / "recording", setup);
  for (int k = 0; k < ideal.frames(); ++k) {
    const slam::Observation o = recording.observation(k);
    writer.add(o);
    writer.add(sim::recording::TruePoses{o.t, ideal.X_WC(slam::seconds(o.t)), ideal.X_WC(slam::seconds(o.t)),
                                         o.plan->X_PC});
  }
  writer.add(walls());
  writer.finish();
  std::ofstream(folder / "scenario.yaml")
      << "name: synthetic\nwalk: {commands: [{stand: {duration_s: " << ideal.duration_s
      << "}}]}\ncamera: {}\nslam: {}\n" + text;
  std::ofstream(folder / "about.json") << R"({"walk_ending": "completed"})";
}

}  // namespace tests
