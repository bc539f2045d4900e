// The CPU and wall times of a run. No result depends on these clocks.
#pragma once

#include <chrono>
#include <filesystem>
#include <vector>

#include "slam/observation.h"

namespace sim::result {

/// Returns the CPU time of the calling thread (ms).
double thread_cpu_ms();

/// The CPU time of a frame by stage.
struct FrameTiming {
  slam::Stamp t{0};
  double plan_and_physics_ms = 0, render_ms = 0, encode_ms = 0, record_ms = 0, filter_ms = 0;  ///< CPU
  int landmarks = 0;     ///< in the filter's map after the frame
  bool answered = true;  ///< false: the frame was dropped, or the estimator has failed
};

/// Adds the CPU time of this thread during its lifetime to a stage.
class StageClock {
 public:
  explicit StageClock(double& stage_ms) : stage_ms_(stage_ms), begin_ms_(thread_cpu_ms()) {}
  ~StageClock() { stage_ms_ += thread_cpu_ms() - begin_ms_; }
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;

 private:
  double& stage_ms_;
  double begin_ms_;
};

/// All timings of a run; the wall clock starts with it.
class Timing {
 public:
  std::vector<FrameTiming> frames;
  bool each_frame = true;  ///< false: only the sum of filter_ms is measured, as of a command

  /// Writes timing.csv (one row per frame) and timing.json: frame_cpu_ms_mean of the estimator's CPU time in
  /// frames with an answer, _median and _p99 if that of each frame is known, realtime_factor (simulated
  /// seconds per wall second of the whole run) and the total of each stage. Throws FileError.
  void write(const std::filesystem::path& folder, double simulated_s) const;

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace sim::result
