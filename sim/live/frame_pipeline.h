// Frames from their stamps until their images are drawn, and the camera that takes them.
#pragma once

#include <chrono>
#include <deque>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "sim/camera/head_camera.h"
#include "sim/camera/shutter.h"
#include "sim/live/ordered_worker.h"
#include "sim/physics/world.h"
#include "sim/recording/recording.h"
#include "sim/scenario/scenario.h"
#include "slam/observation.h"

namespace sim::live {

/// A frame and the true pose of the camera at its stamp.
struct Frame {
  slam::Observation observation;
  Eigen::Isometry3d X_WC;
  std::string png = {};                 ///< the image, encoded for the recording
  double render_ms = 0, encode_ms = 0;  ///< CPU time that drawing and encoding its image took
};

/// Frame k is stamped at the millisecond of the physics nearest to k / rate; its image is complete when the
/// shutter has closed, which may be later. Without a camera in the scenario images stay empty. Images do not
/// change the walk, so that they can be drawn beside it: they are the same, and come in the same order, as
/// when each is drawn before the walk goes on.
class FramePipeline {
 public:
  /// beside: images are drawn on a thread of their own, a few frames behind the walk.
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

  /// Has the images drawn whose shutters have closed at this time.
  void draw_complete(std::chrono::nanoseconds t);
  /// Has all images drawn: no more time will pass.
  void draw_all();
  /// Whether so many images are being drawn that the oldest frame is to be taken now.
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
