// The recording of a run, checked against its truth while it is written.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/live/frame_pipeline.h"
#include "sim/live/self_check.h"
#include "sim/recording/recording.h"

namespace sim::live {

/// Writes what ideal sensors gave and where everything truly was.
class CheckedRecording {
 public:
  /// start: true motion at t = 0. surfaces: of the room; images are checked where there are any.
  CheckedRecording(const std::filesystem::path& folder, const recording::RecordingSetup& setup,
                   const recording::TrueMotion& start, const std::vector<score::Surface>& surfaces);

  void add(const recording::BodyReading& reading) { writer_.add(reading); }
  void add(const recording::TruePoses& poses) { writer_.add(poses); }
  void add(const recording::TrueFeet& feet) { writer_.add(feet); }
  void add(const std::vector<score::StepCorrection>& steps) { writer_.add(steps); }
  void add(const Frame& frame);
  /// A reading of the chest IMU, which the frame it belongs to records, and the true motion at its end.
  void add(const slam::InertialSample& gyro, const slam::InertialSample& accelerometer,
           const recording::TrueMotion& end);

  /// Writes the figures of the self check and closes the recording. Returns what does not agree with the
  /// truth, in words; empty if all does.
  std::string finish();

 private:
  recording::RecordingWriter writer_;
  SelfCheck check_;
};

}  // namespace sim::live
