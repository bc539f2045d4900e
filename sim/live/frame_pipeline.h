// Handles frames from their stamps until their images are drawn, and the readings of cameras and lidars,
// each at its own rate.
#pragma once

#include <condition_variable>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "sim/camera/head_camera.h"
#include "sim/physics/world.h"
#include "sim/scenario/scenario.h"
#include "sim/score/types.h"
#include "slam/observation.h"

namespace sim::live {

/// Calls functions in the order of do_next(), all on one thread: its own, or the caller's within do_next().
/// Its destructor drops functions that have not started.
class OrderedWorker {
 public:
  explicit OrderedWorker(bool own_thread) {
    if (own_thread) thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
  }
  /// Returns a future with the function's result or exception.
  template <typename Function>
  auto do_next(Function function) {
    std::packaged_task<std::invoke_result_t<Function>()> task(std::move(function));
    auto result = task.get_future();
    if (thread_.joinable()) {
      const std::lock_guard lock(mutex_);
      waiting_.emplace_back(std::move(task));
      changed_.notify_one();
    } else {
      task();
    }
    return result;
  }

 private:
  void work(const std::stop_token& stop) {
    for (std::unique_lock lock(mutex_);;) {
      changed_.wait(lock, stop, [this] { return !waiting_.empty(); });
      if (stop.stop_requested()) return;
      std::packaged_task<void()> task = std::move(waiting_.front());
      waiting_.pop_front();
      lock.unlock();
      task();
      lock.lock();
    }
  }

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<std::packaged_task<void()>> waiting_;
  std::jthread thread_;  // last: it uses the members above
};

/// A frame and the true pose of the camera at its stamp.
struct Frame {
  slam::Observation observation;
  Eigen::Isometry3d X_WC;
  std::string png = {};                    ///< the image, encoded for the recording
  double render_ms = 0, encode_ms = 0;     ///< CPU time for drawing and encoding its images
  std::vector<std::string> rig_pngs = {};  ///< images of the rig's readings; empty if a reading has none
};

/// Image k of a camera is stamped at the physics millisecond nearest to k / rate and is complete when its
/// shutter has closed. Sweep k of a lidar is stamped at its start and is complete at its end. Drawing in
/// parallel with the walk, with a drawing and an encoding thread for each sensor, gives the same bits in the
/// same order.
class FramePipeline {
 public:
  /// beside: draws images on separate threads, a few frames behind the walk.
  FramePipeline(const scenario::Scenario& scenario, const physics::Models& models, bool beside);
  ~FramePipeline();
  /// Returns the surfaces that the camera can see.
  const std::vector<score::Surface>& surfaces() const { return surfaces_; }
  /// Adds the positions from which later images are drawn. Must be called every millisecond.
  void add_positions(const physics::World& world) {
    if (!sensors_.empty()) motion_.add(world.time(), *world.model(), *world.data());
  }
  /// Returns the stamp of the next frame.
  std::chrono::nanoseconds next_due() const;
  /// Returns the time of the next event: a frame to stamp or an image to draw.
  std::chrono::nanoseconds next_event() const;
  void push(Frame frame) { frames_.push_back(std::move(frame)), ++next_; }
  /// Draws the images whose shutters have closed by this time; at the end of the walk, all remaining ones.
  void draw_complete(std::chrono::nanoseconds t = std::chrono::nanoseconds::max());
  /// Returns whether the oldest frame must be popped because enough images are in flight.
  bool is_full() const { return drawn_.size() > in_flight_; }
  bool empty() const { return drawn_.empty(); }
  /// Returns the stamp of the frame that pop() returns next; there must be one.
  std::chrono::nanoseconds next_stamp() const { return drawn_.front().frame.observation.t; }
  /// Returns the time from a frame's stamp until its shutter closes.
  std::chrono::nanoseconds lead() const { return lead_; }
  /// Waits for the oldest frame's images and returns the frame. Rethrows errors from drawing it.
  Frame pop();
  /// Frees the room's textures, which take more memory than truth and estimates of a long walk.
  void close_cameras();

 private:
  class Sensor;
  using SensorIndex = std::optional<std::size_t>;  // in the rig; none: the head camera
  struct Reading {
    SensorIndex sensor;
    slam::RigReading reading = {};
    std::string png = {};                 // the image, encoded for the recording
    double render_ms = 0, encode_ms = 0;  // CPU time
  };
  using Encoded = std::future<std::vector<Reading>>;  // a sensor's readings at one time
  struct Drawn {
    Frame frame;
    std::vector<std::future<Encoded>> readings;
  };

  camera::CameraOptions options_;
  std::chrono::nanoseconds lead_;
  std::vector<score::Surface> surfaces_;
  std::vector<std::unique_ptr<Sensor>> sensors_;  // the head camera first; none without a camera
  camera::RecentMotion motion_;
  std::deque<Frame> frames_;  // frames whose shutters are open
  std::deque<Drawn> drawn_;   // drawn or being drawn
  std::size_t in_flight_;
  int next_ = 0;
};

}  // namespace sim::live
