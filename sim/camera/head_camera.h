// The head camera: 8-bit grey frames of the room through the lens of a real camera.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

#include "sim/camera/lens.h"
#include "sim/camera/options.h"
#include "sim/camera/scene.h"
#include "sim/camera/shutter.h"
#include "sim/physics/model.h"
#include "sim/physics/options.h"

namespace sim::camera {

/// Pose of a camera of the model in W, optical axes (x right, y down, z forward); positions must be computed
/// (mj_kinematics and mj_camlight, or mj_step1, or mj_forward). Throws std::invalid_argument for an unknown
/// name.
Eigen::Isometry3d camera_pose(const mjModel& model, const mjData& data, const std::string& name);

/// Renders what the camera "head_camera" of a model sees. The same positions give the same bytes.
/// The model is the robot in its furnished room, and the camera's own: the physics that moves the robot knows
/// only the floor, as each visible geom would slow every step. Owns the OpenGL context of the
/// thread that made it; draw from that thread only.
class HeadCamera {
 public:
  /// Throws std::runtime_error without OpenGL, std::invalid_argument if the model has no
  /// head_camera.
  HeadCamera(physics::Model robot_in_room, const CameraOptions& options, std::uint64_t texture_seed = 1);

  const CameraModel& camera() const { return camera_; }
  const mjModel& model() const { return *model_; }
  /// Grey frame (CV_8UC1, height x width of the options) of a robot with the joint positions of
  /// `plant`.
  cv::Mat render(const mjData& plant);

  /// Time from a frame's stamp to the end of its exposure: 0 for a shutter that takes no time.
  std::chrono::milliseconds lead() const { return shutter_.lead(); }
  /// Frame stamped t, through the shutter: of a robot with this `motion` from t - lead() to t +
  /// lead(), while the room's lamps were on or off.
  cv::Mat render(const RecentMotion& motion, std::chrono::nanoseconds t,
                 const physics::WorldOptions::LightsOff& lights_off);

 private:
  cv::Mat picture(const double* q, float light);

  physics::Model model_;
  physics::Data data_;
  CameraModel camera_;
  LensWarp lens_;
  Scene scene_;
  Shutter shutter_;
};

}  // namespace sim::camera
