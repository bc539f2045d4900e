// How fast a run goes on, as its viewers want it.
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
    double speed = 0;  ///< times the real time; 0: as fast as it goes
  };

  void pause();
  void resume();
  /// Goes on for `period` of simulated time, then pauses.
  void step(slam::Stamp period);
  void set_speed(double factor);
  /// Nobody commands any more: goes on, as fast as it goes.
  void release();
  State state() const;

  /// By the run at simulated time t: returns when it may go on.
  void wait(slam::Stamp t);

 private:
  void begin_anew();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  State state_;
  slam::Stamp now_{0}, until_{0};  // while paused it goes on to until_
  slam::Stamp from_{0};            // simulated time at from_clock_
  Clock::time_point from_clock_ = Clock::now();
};

}  // namespace sim::view
