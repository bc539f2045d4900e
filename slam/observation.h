// Everything the filter is ever given: one struct, spoken by live run, replay, sensor errors, recordings and
// tests.
#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace slam {

/// Time since the start of the run on the simulated (or the robot's) clock.
using Stamp = std::chrono::nanoseconds;

/// A stamp, or the time between two, in s.
inline double seconds(Stamp t) { return std::chrono::duration<double>(t).count(); }

/// One inertial reading: the mean over (begin, end], so that readings chain without gaps and a gap is
/// visible. A 200 Hz reading is split where a camera frame falls inside it. Axes: G, the chest IMU.
struct InertialSample {
  Stamp begin{0};
  Stamp end{0};
  Eigen::Vector3d value =
      Eigen::Vector3d::Zero();  ///< gyro: rad/s · accelerometer: specific force, m/s² (+g up at rest)
};

/// Which feet the walking plan has on the ground.
enum class Support { both, left, right };

/// The pattern generator's word on the camera at the time of the frame, in the plan's own world P (equal to W
/// at the start, drifting from it as the feet slip). X_PC maps camera points to P. v_PC_C, w_PC_C: planned
/// linear (m/s) and angular (rad/s) velocity of the camera in P, expressed in the camera's own axes C.
struct PlannedMotion {
  Eigen::Isometry3d X_PC = Eigen::Isometry3d::Identity();
  Eigen::Vector3d v_PC_C = Eigen::Vector3d::Zero();
  Eigen::Vector3d w_PC_C = Eigen::Vector3d::Zero();
  /// The sole of the support foot as planned (both feet: the middle between them), m in C: about what the
  /// robot tilts.
  Eigen::Vector3d p_CF = Eigen::Vector3d::Zero();
  Support support = Support::both;
};

/// One frame and all that came since the one before. What is missing is absent: an empty image, an empty
/// vector, no plan.
struct Observation {
  Stamp t{0};
  cv::Mat image;                     ///< 8-bit grey (CV_8UC1), rows x cols of the camera; empty = frame lost
  std::vector<InertialSample> gyro;  ///< since the previous frame, in order of time
  std::vector<InertialSample> accelerometer;  ///< likewise
  std::optional<PlannedMotion> plan;
};

}  // namespace slam
