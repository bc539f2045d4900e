#include "sim/view/pace.h"

#include <algorithm>

namespace sim::view {

void Pace::restart() {
  from_ = now_;
  from_clock_ = Clock::now();
  changed_.notify_all();
}

void Pace::pause() {
  const std::lock_guard lock(mutex_);
  state_.paused = true;
  until_ = now_;
}

void Pace::resume() {
  const std::lock_guard lock(mutex_);
  state_.paused = false;
  restart();
}

void Pace::step(slam::Stamp period) {
  const std::lock_guard lock(mutex_);
  until_ = (state_.paused ? std::max(until_, now_) : now_) + period;
  state_.paused = true;
  restart();
}

void Pace::set_speed(double factor) {
  const std::lock_guard lock(mutex_);
  state_.speed = factor;
  restart();
}

void Pace::release() {
  const std::lock_guard lock(mutex_);
  state_ = {};
  changed_.notify_all();
}

Pace::State Pace::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

void Pace::wait(slam::Stamp t) {
  std::unique_lock lock(mutex_);
  now_ = t;
  for (;;) {
    if (state_.paused) {
      if (t < until_) return;
      changed_.wait(lock);
      continue;
    }
    if (state_.speed == 0) return;
    const auto due = from_clock_ + std::chrono::duration_cast<Clock::duration>((t - from_) / state_.speed);
    if (Clock::now() >= due) return;
    changed_.wait_until(lock, due);
  }
}

}  // namespace sim::view
