// Poses, trajectories, a camera and a room for tests of the score. The poses are upright, and the camera is
// the simplest possible.
#pragma once

#include "sim/score/metrics.h"
#include "sim/score/run.h"

namespace sim::score {

inline Eigen::Matrix3d about_z(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

/// An upright pose at a place (m), turned about z by `yaw_rad`.
inline Eigen::Isometry3d upright(double x, double y, double z, double yaw_rad = 0) {
  Eigen::Isometry3d X(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
  X.translation() = Eigen::Vector3d(x, y, z);
  return X;
}

/// A curve in space with turning poses, paired with itself.
inline std::vector<PosePair> curve_pairs() {
  std::vector<PosePair> pairs;
  for (int i = 0; i < 40; ++i) {
    const double s = 0.1 * i;
    Eigen::Isometry3d X(Eigen::AngleAxisd(s, Eigen::Vector3d(0.1, 0.2, 1).normalized()));
    X.translation() = Eigen::Vector3d(std::cos(s), std::sin(s), 0.3 * std::sin(2 * s));
    pairs.push_back({i * Stamp(33'333'333), X, X});
  }
  return pairs;
}

/// A pinhole camera with a horizontal field of view of 90° and 320x240 pixels.
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
  for (const int u : {0, 80, 160, 240, 320})
    for (const int v : {0, 120, 240}) camera.grid.push_back(camera.bearing(Eigen::Vector2d(u, v)));
  return camera;
}

/// A room 3 m high, seen from inside, with walls `half_width` (m) away from the origin.
inline Surface box_room(double half_width) {
  return {Surface::Kind::box, upright(0, 0, 1.5), {half_width, half_width, 1.5}};
}

/// A level camera 1.4 m above the origin that looks along x of W, turned left by `turn`.
inline Eigen::Isometry3d looking(double turn) {
  Eigen::Isometry3d X = upright(0, 0, 1.4);
  X.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  X.linear() = about_z(turn) * X.linear();
  return X;
}

/// A run and its metrics.
class RunTest : public testing::Test {
 protected:
  Metric metric(const std::string& name) const { return evaluate(run).at(name); }
  /// The value, which must be there.
  double value(const std::string& name) const {
    const Metric found = metric(name);
    EXPECT_TRUE(found.value) << name << ": " << found.reason;
    return found.value.value_or(std::nan(""));
  }
  /// The reason why the value is absent.
  std::string reason(const std::string& name) const {
    const Metric found = metric(name);
    EXPECT_FALSE(found.value) << name;
    return found.reason;
  }
  score::Run run;
};

}  // namespace sim::score
