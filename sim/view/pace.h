// The speed of a run, as its viewers set it.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>

#include "slam/observation.h"

namespace sim::view {

/// Commands come from one thread, the run waits in another.
class Pace {
 public:
  struct State {
    bool paused = false;
    double speed = 0;  ///< times real time; 0: full speed
  };

  void pause() {
    change([&] { state_.paused = true, until_ = now_; });
  }
  void resume() {
    change([&] { state_.paused = false; });
  }
  /// Runs for `period` of simulated time, then pauses.
  void step(slam::Stamp period) {
    change([&] {
      until_ = (state_.paused ? std::max(until_, now_) : now_) + period;
      state_.paused = true;
    });
  }
  void set_speed(double factor) {
    change([&] { state_.speed = factor; });
  }
  /// No controlling viewer: runs at full speed.
  void release() {
    change([&] { state_ = {}; });
  }
  State state() const {
    const std::lock_guard lock(mutex_);
    return state_;
  }

  /// Called by the run at simulated time t: returns when it may continue.
  void wait(slam::Stamp t) {
    std::unique_lock lock(mutex_);
    for (now_ = t; state_.paused ? t >= until_ : state_.speed > 0;) {
      if (state_.paused) {
        changed_.wait(lock);
        continue;
      }
      const auto due = from_clock_ + std::chrono::duration_cast<Clock::duration>((t - from_) / state_.speed);
      if (Clock::now() >= due) return;
      changed_.wait_until(lock, due);
    }
  }

 private:
  using Clock = std::chrono::steady_clock;

  void change(const auto& set) {
    const std::lock_guard lock(mutex_);
    set();
    from_ = now_, from_clock_ = Clock::now();
    changed_.notify_all();
  }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  State state_;
  slam::Stamp now_{0}, until_{0};  // while paused it runs to until_
  slam::Stamp from_{0};            // simulated time at from_clock_
  Clock::time_point from_clock_ = Clock::now();
};

}  // namespace sim::view
