#include "sim/view/pace.h"

#include <atomic>
#include <thread>

namespace sim::view {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// A run of ticks of 5 ms in its own thread.
class TickingRun {
 public:
  explicit TickingRun(Pace& pace)
      : pace_(pace), thread_([this] {
          for (slam::Stamp t = 5ms; !ended_; t += 5ms) {
            pace_.wait(t);
            at_ms_ = t / 1ms;
          }
        }) {}
  ~TickingRun() {
    ended_ = true;
    pace_.release();
    thread_.join();
  }
  /// Simulated time after it stopped.
  long rest() const {
    long before = -1;
    for (long now = at_ms_; now != before; now = at_ms_) {
      before = now;
      std::this_thread::sleep_for(100ms);
    }
    return before;
  }
  long at_ms() const { return at_ms_; }

 private:
  Pace& pace_;
  std::atomic<long> at_ms_{0};
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

TEST(Pace, AStepGoesOnForItsPeriodAndResumedItGoesOn) {
  Pace pace;
  pace.set_speed(1);
  TickingRun run(pace);
  pace.pause();
  const long paused = run.rest();
  pace.step(34ms);
  const long after = run.rest();
  EXPECT_GE(after, paused + 30);
  EXPECT_LE(after, paused + 40);
  EXPECT_TRUE(pace.state().paused);
  pace.resume();
  std::this_thread::sleep_for(300ms);
  EXPECT_GT(run.at_ms(), after + 100);
}

TEST(Pace, SpeedIsThatOfSimulatedTimeAndFullUnlessItIsSet) {
  Pace pace;
  auto begin = Clock::now();
  for (slam::Stamp t{0}; t < 1000s; t += 1s) pace.wait(t);
  EXPECT_LT(Clock::now() - begin, 5s);
  pace.set_speed(0.25);
  begin = Clock::now();
  for (slam::Stamp t = 999s; t <= 999s + 100ms; t += 5ms) pace.wait(t);
  EXPECT_GE(Clock::now() - begin, 390ms);  // it never runs ahead; how late it is depends on the machine
  EXPECT_LT(Clock::now() - begin, 3s);
}

TEST(Pace, WithoutViewersItIsNeitherPausedNorSlow) {
  Pace pace;
  pace.pause();
  TickingRun run(pace);
  run.rest();
  pace.release();
  std::this_thread::sleep_for(100ms);
  EXPECT_GT(run.at_ms(), 1000);
}

}  // namespace
}  // namespace sim::view
