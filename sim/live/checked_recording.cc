#include "sim/live/checked_recording.h"

namespace sim::live {

CheckedRecording::CheckedRecording(const std::filesystem::path& folder,
                                   const recording::RecordingSetup& setup, const recording::TrueMotion& start,
                                   const std::vector<score::Surface>& surfaces)
    : writer_(folder, setup), check_{InertialCheck(start), {}} {
  for (const score::Surface& surface : surfaces) writer_.add(surface);
  if (!surfaces.empty()) check_.view.emplace(setup.calibration.camera, surfaces);
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
