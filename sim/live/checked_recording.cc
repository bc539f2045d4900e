#include "sim/live/checked_recording.h"

#include "sim/result/score_input.h"

namespace sim::live {

CheckedRecording::CheckedRecording(const std::filesystem::path& folder,
                                   const recording::RecordingSetup& setup, const recording::TrueMotion& start,
                                   const std::vector<recording::RecordedSurface>& surfaces)
    : writer_(folder, setup), check_{InertialCheck(start), {}} {
  std::vector<score::Surface> scored;
  for (const recording::RecordedSurface& surface : surfaces) {
    writer_.add(surface);
    scored.push_back(result::surface(surface));
  }
  if (!surfaces.empty()) check_.view.emplace(setup.calibration.camera, scored);
}

void CheckedRecording::add(const Frame& frame) {
  writer_.add(frame.observation, frame.png);
  if (check_.view) check_.view->add(frame.observation.image, frame.observation.t, frame.X_WC);
}

void CheckedRecording::add(const slam::InertialSample& gyro, const slam::InertialSample& accelerometer,
                           const recording::TrueMotion& end) {
  writer_.add(end);
  check_.inertial.add(gyro, accelerometer, end);
}

std::string CheckedRecording::finish() {
  writer_.add("self_check.json", check_.json());
  writer_.finish();
  return check_.complaint();
}

}  // namespace sim::live
