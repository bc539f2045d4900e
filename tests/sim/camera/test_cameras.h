// Cameras and mounting places for tests of the renderer, independent of the renderer's lens.
#pragma once

#include "sim/camera/head_camera.h"
#include "slam/camera.h"
#include "tests/sim/physics/test_worlds.h"

namespace sim::camera {

/// A robot that consists only of a flying head camera, in a room with the given geoms.
inline physics::Model head_in(const std::string& room) {
  return physics::small_model(
      "<visual><headlight ambient='1 1 1' diffuse='0 0 0' specular='0 0 0'/></visual><worldbody>" + room +
          "</worldbody>",
      "<worldbody><body name='head'><freejoint/><geom type='sphere' size='0.01' group='2'/>"
      "<camera name='head_camera' xyaxes='0 -1 0 0 0 1'/></body></worldbody>");
}

/// Center of gravity of the pixels in a window, each weighted by `brightness`.
template <typename Brightness>
Eigen::Vector2d centroid(const cv::Rect& window, Brightness brightness) {
  Eigen::Vector2d sum(0, 0);
  double weight = 0;
  for (int v = window.y; v < window.y + window.height; ++v)
    for (int u = window.x; u < window.x + window.width; ++u) {
      const double w = brightness(u, v);
      sum += w * Eigen::Vector2d(u, v), weight += w;
    }
  return sum / weight;
}

/// Computes all positions at time t_s of the motion from the joint angles. Returns X_WL of a place.
inline Eigen::Isometry3d pose_of(const mjModel& model, mjData& data, const RecentMotion& motion,
                                 const physics::Place& place, double t_s) {
  const Eigen::VectorXd q = motion.at(t_s, model);
  std::ranges::copy(q, data.qpos);
  mj_kinematics(&model, &data);
  const Eigen::Map<const Eigen::Vector4d> q_WB(data.xquat + 4 * place.body);  // shared code uses xmat
  return Eigen::Translation3d(Eigen::Map<const Eigen::Vector3d>(data.xpos + 3 * place.body)) *
         Eigen::Quaterniond(q_WB[0], q_WB[1], q_WB[2], q_WB[3]) * place.X_BL;
}

}  // namespace sim::camera
