// Frames from their stamps until their images are drawn, and the worker that draws them.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "sim/camera/head_camera.h"
#include "sim/camera/shutter.h"
#include "sim/physics/world.h"
#include "sim/recording/recording.h"
#include "sim/scenario/scenario.h"
#include "slam/observation.h"

namespace sim::live {

/// Calls functions one after another, in the order of do_next(), all on one thread: its own, or the caller's
/// within do_next(). Objects that belong to one thread, as OpenGL's contexts do, are made, used and destroyed
/// by such functions. Functions that have not started when the worker is destroyed are dropped.
class OrderedWorker {
 public:
  explicit OrderedWorker(bool own_thread);
  ~OrderedWorker();
  OrderedWorker(const OrderedWorker&) = delete;
  OrderedWorker& operator=(const OrderedWorker&) = delete;

  /// The future has the function's result or exception.
  template <typename Function>
  auto do_next(Function function) {
    // Shared, since std::function copies.
    auto task = std::make_shared<std::packaged_task<std::invoke_result_t<Function>()>>(std::move(function));
    auto result = task->get_future();
    add([task] { (*task)(); });
    return result;
  }

 private:
  void add(std::function<void()> task);
  void work();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> waiting_;
  bool stopping_ = false;
  std::thread thread_;  // last: it uses the members above
};

/// A frame and the true pose of the camera at its stamp.
struct Frame {
  slam::Observation observation;
  Eigen::Isometry3d X_WC;
  std::string png = {};                 ///< the image, encoded for the recording
  double render_ms = 0, encode_ms = 0;  ///< CPU time that drawing and encoding its image took
};

/// Frame k is stamped at the millisecond of the physics nearest to k / rate; its image is complete when the
/// shutter has closed, which may be later. Without a camera in the scenario images stay empty. Images do not
/// change the walk, so they can be drawn beside it, with the same bits and in the same order.
class FramePipeline {
 public:
  /// beside: images are drawn on a separate thread, a few frames behind the walk.
  FramePipeline(const scenario::Scenario& scenario, const physics::Models& models, bool beside);

  /// The surfaces that the camera can see.
  const std::vector<score::Surface>& surfaces() const { return surfaces_; }

  /// To be called at each millisecond: the positions that later images are drawn at.
  void add_positions(const physics::World& world);
  /// When the next frame is stamped.
  std::chrono::nanoseconds next_due() const;
  /// When there is something to do next: a frame to stamp, or an image to draw.
  std::chrono::nanoseconds next_event() const;
  void push(Frame frame);

  /// Draws the images with shutters closed at this time.
  void draw_complete(std::chrono::nanoseconds t);
  /// Draws all remaining images at the end of the walk.
  void draw_all();
  /// Returns whether the oldest frame must be popped because enough images are in flight.
  bool is_full() const { return drawn_.size() > in_flight_; }
  bool empty() const { return drawn_.empty(); }
  /// The stamp of the frame that pop() gives next; there must be one.
  std::chrono::nanoseconds next_stamp() const { return drawn_stamps_.front(); }
  /// Time from a frame's stamp until its shutter has closed.
  std::chrono::nanoseconds lead() const { return lead_; }
  /// The oldest frame, with its image, once that is drawn. Throws what drawing it has thrown.
  Frame pop();

  /// Frees the room's textures, which take more memory than truth and estimates of a long walk.
  void close_camera();

 private:
  void draw_oldest();

  camera::CameraOptions options_;
  physics::WorldOptions::LightsOff lights_off_;
  std::chrono::nanoseconds lead_;
  std::vector<score::Surface> surfaces_;
  camera::RecentMotion motion_;
  std::deque<Frame> frames_;              // their shutters are open
  std::deque<std::future<Frame>> drawn_;  // or being drawn
  std::deque<std::chrono::nanoseconds> drawn_stamps_;
  std::size_t in_flight_;
  int next_ = 0;
  std::unique_ptr<camera::HeadCamera> camera_;  // made, used and destroyed by the worker
  OrderedWorker worker_;                        // last: its functions use the members above
};

}  // namespace sim::live
