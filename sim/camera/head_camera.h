// The head camera: 8-bit gray frames of the room through the lens and the shutter of a real camera.
#pragma once

#include <chrono>
#include <deque>

#include "sim/camera/lens.h"
#include "sim/camera/options.h"
#include "sim/camera/scene.h"
#include "sim/physics/model.h"
#include "sim/physics/options.h"

namespace sim::camera {

/// The exposure of each row of a frame. In a frame of H rows stamped t, the exposure of row v starts at t +
/// readout ((v + 1/2) / H - 1/2) - exposure/2: the stamp is the middle of the middle row's exposure. Pictures
/// are drawn at evenly spaced moments, and the light between two of them is interpolated.
class Shutter {
 public:
  explicit Shutter(const CameraOptions& options);
  /// Returns when to draw pictures, in s from the stamp; only 0 for a shutter that takes no time.
  const std::vector<double>& moments() const { return moments_; }
  /// Returns the frame composed of one picture for each moment.
  cv::Mat expose(const std::vector<cv::Mat>& pictures) const;

 private:
  std::vector<double> moments_;
  cv::Mat1f shares_;  ///< weight of each moment's picture (row) in each image row (column)
};

/// The robot's recent positions, at most a millisecond apart.
class RecentMotion {
 public:
  explicit RecentMotion(std::chrono::nanoseconds kept) : kept_(kept) {}

  /// Adds positions. `t` must be later than all previous times.
  void add(std::chrono::nanoseconds t, const mjModel& model, const mjData& data);
  /// Returns the positions at a time (s), interpolated, or else the nearest ones kept. At least one must have
  /// been added.
  Eigen::VectorXd at(double t_s, const mjModel& model) const;

 private:
  struct Pose {
    double t_s;
    Eigen::VectorXd q;
  };
  std::chrono::nanoseconds kept_;
  std::deque<Pose> poses_;
};

/// A drawn frame: one picture without lens distortion for each of Shutter::moments(), and the depth at the
/// stamp if requested.
struct Exposure {
  std::vector<cv::Mat> pictures;
  std::optional<DepthPicture> depth;
};

/// Renders the view of a model's camera "head_camera". The same positions give the same bytes. The camera has
/// its own model, the robot in its furnished room: the physics has only the floor, because every visible geom
/// would slow its steps. Owns the OpenGL context of the thread that created it; draw only from that thread.
class HeadCamera {
 public:
  /// channels: RGB for a color camera. mount: for an additional camera of the rig, placed as by
  /// physics::place_of(). shares: a camera in the same room with the same channels, whose textures are
  /// shared. Throws std::runtime_error without OpenGL, std::invalid_argument if the model has no head_camera.
  HeadCamera(physics::Model robot_in_room, const CameraOptions& options, std::uint64_t texture_seed = 1,
             Channels channels = Channels::gray, const rig::Mount& mount = {},
             const HeadCamera* shares = nullptr);

  const mjModel& model() const { return *model_; }
  /// Returns the gray frame (CV_8UC1, height x width of the options) at the joint positions of `plant`.
  cv::Mat render(const mjData& plant) { return image({{picture(plant.qpos, plant.time, 1)}, {}}); }
  /// Draws the frame stamped t in the light of the world at that time. `motion` must cover the time from t -
  /// lead() of the options to t + lead().
  Exposure expose(const RecentMotion& motion, std::chrono::nanoseconds t, const physics::WorldOptions& world,
                  bool with_depth = false);
  /// Returns the frame through lens and shutter. May be called on any thread, as may depth_mm().
  cv::Mat image(const Exposure& exposure) const;
  /// Returns the depth along the camera's axis at the stamp (CV_16UC1, mm; 0: none, as on window panes).
  cv::Mat1w depth_mm(const Exposure& exposure) const {
    return lens_.depth_mm(exposure.depth.value().inverse_depth());
  }

 private:
  cv::Mat picture(const double* q, double t_s, float light);

  physics::Model model_;
  physics::Data data_;
  LensWarp lens_;
  Scene scene_;
  Shutter shutter_;
  int id_;  ///< the camera's id in the model
};

}  // namespace sim::camera
