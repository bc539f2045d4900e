// A textured 7 x 11 x 3 m room with furniture, ray-cast through the filter's lens, and walks along a circle.
#pragma once

#include <cstdint>
#include <random>

#include "slam/camera.h"
#include "slam/observation.h"

namespace slam::synthetic {

/// Normal numbers from a seed, the same on every machine.
class Normal {
 public:
  explicit Normal(std::uint64_t seed) : random_(seed) {}
  double operator()();

 private:
  std::mt19937_64 random_;
};

/// Planes and boxes with printed textures, lit evenly.
class Room {
 public:
  Room();
  /// The view of a camera at X_WC in 8-bit gray, with side x side rays per pixel.
  cv::Mat render(const Camera& camera, const Eigen::Isometry3d& X_WC, int side) const;
  /// The first intersection of the ray from `origin` along `direction` with a surface.
  Eigen::Vector3d hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

 private:
  struct Surface {
    float distance;
    int texture, axis;
  };
  Surface nearest(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const;
  float gray(const Surface& surface, const Eigen::Vector3f& point, float footprint) const;

  struct Box {
    Eigen::Vector3f low, high;
  };
  std::vector<Box> furniture_;
  Box walls_;
  std::vector<std::vector<cv::Mat>> textures_;  // [surface][level], one texel 1 cm · 2^level
};

/// A walk along a circle, always looking along its tangent, and the sensor readings of it.
struct Walk {
  double radius_m = 0.75, duration_s = 28, stand_s = 0.5;
  double turns = 1;  ///< rounds of the circle, walked in duration_s
  double sway_m = 0.03, bounce_m = 0.01, step_s = 0.8;
  double slip = 0.03;        ///< the plan walks this much further than the robot
  double yaw_error = 0.042;  ///< the plan turns this much further
  double gyro_sigma_rad_s = 0.01, accelerometer_sigma_m_s2 = 0.05, image_sigma = 2;
  double rate_hz = 30;

  int frames() const { return static_cast<int>(duration_s * rate_hz) + 1; }
  Stamp stamp(int frame) const;
  /// True camera pose at a time, in W.
  Eigen::Isometry3d X_WC(double t_s) const;
};

/// The default camera, and chest sensors that are rotated and below it.
Calibration calibration();

/// The images of a walk without noise.
std::vector<cv::Mat> render(const Room& room, const Walk& walk, int side = 1);

/// The frames of a walk: images (rendered once), and the noisy observations.
class Recording {
 public:
  /// images: rendered before, or none.
  explicit Recording(const Walk& walk, std::vector<cv::Mat> images = {});
  Observation observation(int frame) const;
  const Walk& walk() const { return walk_; }

 private:
  std::vector<InertialSample> inertial(int frame, bool accelerometer, std::uint64_t salt) const;

  Walk walk_;
  std::vector<cv::Mat> images_;
  std::vector<Eigen::Isometry3d> plan_;
};

/// The rendered recording of a walk with that duration along a part of the circle.
Recording recorded(double duration_s, double turns, double rate_hz = 30);

}  // namespace slam::synthetic
