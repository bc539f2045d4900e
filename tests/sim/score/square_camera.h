// A pinhole camera of 90° across and 320x240 for tests of the score, of the simplest kind.
#pragma once

#include "sim/score/landmarks.h"

namespace sim::score {

inline TrueCamera square_camera() {
  TrueCamera camera;
  camera.project = [](const Eigen::Isometry3d& X_WC,
                      const Eigen::Vector3d& p_W) -> std::optional<Eigen::Vector2d> {
    const Eigen::Vector3d p_C = X_WC.inverse() * p_W;
    if (p_C.z() <= 0) return std::nullopt;
    const Eigen::Vector2d pixel = 160 * p_C.head<2>() / p_C.z() + Eigen::Vector2d(160, 120);
    if (pixel.x() < 0 || pixel.x() > 320 || pixel.y() < 0 || pixel.y() > 240) return std::nullopt;
    return pixel;
  };
  camera.bearing = [](const Eigen::Vector2d& pixel) {
    return Eigen::Vector3d((pixel.x() - 160) / 160, (pixel.y() - 120) / 160, 1).normalized();
  };
  return camera;
}

/// A room 3 m high, seen from inside, with walls `half_width` (m) away from the origin.
inline Surface box_room(double half_width) {
  Surface room{Surface::Kind::box, Eigen::Isometry3d::Identity(), {half_width, half_width, 1.5}};
  room.X_WS.translation().z() = 1.5;
  return room;
}

/// A camera at the origin, 1.4 m up, level, looking along x of W turned left by `turn`.
inline Eigen::Isometry3d looking(double turn) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  X.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix() * X.linear();
  X.translation().z() = 1.4;
  return X;
}

}  // namespace sim::score
