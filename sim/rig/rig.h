// The calibrated sensors of a rig, as recordings, estimators, exports and pages know them.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "sim/rig/options.h"
#include "slam/options.h"

namespace sim::rig {

enum class Kind { grey, color, depth, lidar, imu };
/// The kinds in words, in the order of their values.
inline constexpr std::array<std::string_view, 5> kKinds{"grey", "color", "depth", "lidar", "imu"};

/// A further sensor of a recording.
struct RigSensor {
  std::string name;  ///< of its folder
  Kind kind = Kind::grey;
  double rate_hz = 30;
  double time_offset_s = 0;  ///< of its stamps, ahead of the head camera's clock, after sensor errors
  /// The sensor in the frame of the head camera C. Axes of a camera: x right, y down, z forward; of lidar and
  /// IMU: x forward, y left, z up.
  Eigen::Isometry3d X_CS = Eigen::Isometry3d::Identity();
  slam::CameraIntrinsics camera = {};      ///< of gray, color and depth
  std::string aligned_with = {};           ///< of depth: the camera with the same pixels and stamps
  double nearest_m = 0, furthest_m = 0;    ///< of depth and lidar
  double readout_s = 0;                    ///< of gray and color: from the first row to the last
  double lowest_rad = 0, highest_rad = 0;  ///< of a lidar

  // Errors on the way to the estimator (sim/sensor_errors); recorded readings are ideal.
  double read_sigma_grey = 0, shot_sigma_grey = 0;            ///< of gray and color
  double baseline_m = 0, disparity_sigma_px = 0;              ///< of depth
  int edge_px = 0;                                            ///< of depth
  double range_sigma_m = 0, angle_sigma_rad = 0;              ///< of a lidar
  double gyro_sigma_rad_s = 0, accelerometer_sigma_m_s2 = 0;  ///< of an IMU, of one reading
  double gyro_bias_sigma_rad_s = 0, accelerometer_bias_sigma_m_s2 = 0;
  double gyro_bias_walk_rad_s2 = 0, accelerometer_bias_walk_m_s3 = 0;  ///< of the chest IMU
};

/// Standard deviation of the inverse depth 1/z that a depth camera measures, 1/m.
inline double inverse_depth_sigma(const RigSensor& depth) {
  return depth.disparity_sigma_px / (depth.camera.fu_px * depth.baseline_m);
}

/// Returns whether the sensor has images.
inline bool is_camera(const RigSensor& sensor) { return sensor.kind <= Kind::depth; }

/// The axes forward, left, up in those of a camera (right, down, forward).
Eigen::Isometry3d camera_from_forward_left_up();

/// The calibrated sensors of a scenario's list. head: intrinsics of the head camera; head_rate_hz,
/// head_readout_s: its rate and shutter. X_CL: the axes forward, left, up of each item's mount in the head
/// camera's frame, in the order of the items; unused for depth. Throws std::invalid_argument if
/// problem(items) finds one.
std::vector<RigSensor> calibrated(const std::vector<Item>& items, const slam::CameraIntrinsics& head,
                                  double head_rate_hz, double head_readout_s,
                                  const std::vector<Eigen::Isometry3d>& X_CL);

/// The pinhole focal length of a field of view, and a radial lens on it: f = (w/2) / tan(fov/2), the center
/// in the middle.
slam::CameraIntrinsics lens(int width_px, int height_px, double fov_rad, double distortion);

/// Returns the index of the camera that a depth camera is aligned with, or -1 for the head camera.
int partner(const std::vector<RigSensor>& rig, const RigSensor& depth);

/// A camera that approximates another one; the distance of their pixels over the whole image.
struct FittedCamera {
  slam::CameraIntrinsics camera;
  double rms_px = 0, largest_px = 0;
};

/// The equidistant camera nearest to the given one: least squares in the two focal lengths and four
/// coefficients over a grid of pixels that includes the borders. The principal point is kept.
FittedCamera fit_equidistant(const slam::CameraIntrinsics& camera);

}  // namespace sim::rig
