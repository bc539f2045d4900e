// Frames from their stamps until their images are drawn.
#pragma once

#include <chrono>
#include <deque>
#include <future>
#include <string>
#include <vector>

#include "sim/camera/head_camera.h"
#include "sim/live/ordered_worker.h"
#include "sim/live/rig_readings.h"
#include "sim/physics/world.h"
#include "sim/recording/recording.h"
#include "sim/scenario/scenario.h"
#include "slam/observation.h"

namespace sim::live {

/// A frame and the true pose of the camera at its stamp.
struct Frame {
  slam::Observation observation;
  Eigen::Isometry3d X_WC;
  std::string png = {};                    ///< the image, encoded for the recording
  double render_ms = 0, encode_ms = 0;     ///< CPU time that drawing and encoding its images took
  std::vector<std::string> rig_pngs = {};  ///< of the readings of the rig; empty without image
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
  void add_positions(const physics::World& world) {
    if (draws_) motion_.add(world.time(), *world.model(), *world.data());
  }
  /// When the next frame is stamped.
  std::chrono::nanoseconds next_due() const;
  /// When there is something to do next: a frame to stamp, or an image to draw.
  std::chrono::nanoseconds next_event() const;
  void push(Frame frame) { frames_.push_back(std::move(frame)), ++next_; }
  /// Draws the images with shutters closed at this time; all remaining ones at the end of the walk.
  void draw_complete(std::chrono::nanoseconds t = std::chrono::nanoseconds::max());
  /// Returns whether the oldest frame must be popped because enough images are in flight.
  bool is_full() const { return drawn_.size() > in_flight_; }
  bool empty() const { return drawn_.empty(); }
  /// The stamp of the frame that pop() gives next; there must be one.
  std::chrono::nanoseconds next_stamp() const { return drawn_.front().frame.observation.t; }
  /// Time from a frame's stamp until its shutter has closed.
  std::chrono::nanoseconds lead() const { return lead_; }
  /// The oldest frame, with its image, once that is drawn. Throws what drawing it has thrown.
  Frame pop();
  /// Frees the room's textures, which take more memory than truth and estimates of a long walk.
  void close_cameras() { readings_.close(); }

 private:
  struct Drawn {
    Frame frame;
    std::vector<std::future<RigFrames>> readings;
  };

  camera::CameraOptions options_;
  std::chrono::nanoseconds lead_;
  std::vector<score::Surface> surfaces_;
  RigReadings readings_;
  camera::RecentMotion motion_;
  std::deque<Frame> frames_;  // their shutters are open
  std::deque<Drawn> drawn_;   // or being drawn
  bool draws_;                // there is a camera
  std::size_t in_flight_;
  int next_ = 0;
};

}  // namespace sim::live
