// The speed of a run, as its viewers set it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "slam/observation.h"

namespace sim::view {

/// Commands come from one thread, the run waits in another.
class Pace {
 public:
  using Clock = std::chrono::steady_clock;

  struct State {
    bool paused = false;
    double speed = 0;  ///< times real time; 0: full speed
  };

  void pause();
  void resume();
  /// Runs for `period` of simulated time, then pauses.
  void step(slam::Stamp period);
  void set_speed(double factor);
  /// No controlling viewer: runs at full speed.
  void release();
  State state() const;

  /// Called by the run at simulated time t: returns when it may continue.
  void wait(slam::Stamp t);

 private:
  void restart();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  State state_;
  slam::Stamp now_{0}, until_{0};  // while paused it runs to until_
  slam::Stamp from_{0};            // simulated time at from_clock_
  Clock::time_point from_clock_ = Clock::now();
};

}  // namespace sim::view
