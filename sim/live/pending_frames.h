// Frames from their stamps until their shutters have closed, and the camera that takes them.
#pragma once

#include <chrono>
#include <deque>
#include <filesystem>
#include <optional>
#include <vector>

#include "sim/recording/recording.h"
#include "sim/scenario/scenario.h"
#include "sim/world/head_camera.h"
#include "sim/world/shutter.h"
#include "sim/world/world.h"
#include "slam/observation.h"

namespace sim::live {

/// A frame and the true pose of the camera at its stamp.
struct Frame {
  slam::Observation observation;
  Eigen::Isometry3d X_WC;
};

/// Frame k is stamped at the millisecond of the physics nearest to k / rate; its image is complete when the
/// shutter has closed, which may be later. Without a camera in the scenario images stay empty.
class PendingFrames {
 public:
  PendingFrames(const scenario::Scenario& scenario, const std::filesystem::path& models);

  /// The surfaces that the camera can see.
  std::vector<recording::RecordedSurface> surfaces() const;

  /// To be called at each millisecond: the positions that later images are drawn at.
  void add_positions(const world::World& world);
  /// Whether the next frame is stamped at this time.
  bool is_due(std::chrono::nanoseconds t) const;
  void push(Frame frame);

  bool empty() const { return frames_.empty(); }
  /// Whether the image of the oldest frame is complete at this time.
  bool is_complete(std::chrono::nanoseconds t) const;
  /// The oldest frame, with its image.
  Frame pop();

  /// Frees the room's textures, which take more memory than truth and estimates of a long walk.
  void close_camera() { camera_.reset(); }

 private:
  world::CameraOptions options_;
  world::WorldOptions::LightsOff lights_off_;
  std::optional<world::HeadCamera> camera_;
  world::RecentMotion motion_;
  std::deque<Frame> frames_;
  int next_ = 0;
};

}  // namespace sim::live
