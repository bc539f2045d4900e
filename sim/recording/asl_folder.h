// An external recording in the EuRoC/ASL layout (README.md): one camera and a gyro; accelerometer, walking
// plan and truth if present. Times count from the first image.
#pragma once

#include "sim/files/trajectory_file.h"
#include "sim/recording/sensor_yaml.h"
#include "slam/observation.h"

namespace sim::recording {

/// The sensors of an external recording. Without plan0, setup.X_WC_start is the first pose of legs0; without
/// both, its world has its origin at the first camera; its z axis is up according to the first accelerometer
/// readings, if any.
struct AslSensors {
  RecordingSetup setup;
  ImuNoise noise;  ///< zero if not stated
  Eigen::Isometry3d X_BC = Eigen::Isometry3d::Identity();
  bool has_motion = false;           ///< a plan, leg odometry or a command
  slam::Stamp first_image{0};        ///< by the camera's clock
  slam::Stamp imu_ahead{0};          ///< timeshift_cam_imu, subtracted from the stamps of the IMU
  std::vector<std::string> remarks;  ///< "FILE: keys that are not read: ...", for the user
};

/// Reads the observations one after another; the constructor checks calibration, rates and clocks, the
/// headers of all images, and the gyro against the truth. Throws FileError with file, line and column of
/// missing or malformed data.
class AslFolder {
 public:
  explicit AslFolder(const fs::path& folder);
  ~AslFolder();

  const fs::path& folder() const;
  const AslSensors& sensors() const;
  /// Returns the times of all images, from the first one on.
  const std::vector<slam::Stamp>& times() const;
  /// Returns true camera poses X_WC, interpolated linearly at the times between true poses less than 0.1 s
  /// apart; the first is aligned with setup.X_WC_start. For a truth of positions only (Truth::positions_of)
  /// they are positions of its point in its own world; empty without truth.
  const Truth& truth() const;
  /// Returns the next image with the readings since the one before, or nothing after the last. A reading
  /// applies until halfway to its neighbors.
  std::optional<slam::Observation> next();
  /// Returns the progress of next(), 0 to 1.
  double part() const;

 private:
  struct Files;
  std::unique_ptr<Files> files_;
};

/// Returns whether a folder has this layout.
bool is_asl_folder(const fs::path& folder);

/// A reading of a gyro.
struct TimedRotation {
  slam::Stamp t{0};
  Eigen::Vector3d value;  ///< rad/s
};

/// The axis of the truth that an axis of the gyro follows, 0 to 2, and its sign, 1 or -1.
struct FollowedAxis {
  int axis, sign;
  bool operator==(const FollowedAxis&) const = default;
};

struct GyroComparison {
  double late_s;                   ///< stamps of the gyro minus those of the truth; 0 without evidence
  double correlation, as_stamped;  ///< of the speeds of rotation, at this offset and at none
  double gain;                     ///< the gyro's speeds relative to those of the truth
  /// The axes of the truth that those of the gyro follow, if these are decisively others than their own.
  std::optional<std::array<FollowedAxis, 3>> axes = {};
  bool mirrored = false;  ///< no rotation of the body explains the gyro, but one of its mirror image does
  std::optional<double> turned_rad = {};  ///< angle between the axes of both, if it is decisively not 0
};

/// Compares a gyro with the truth of the first hour by their turns over 0.1 s, without bias; R_GT: from the
/// axes of the truth to the gyro's. An offset of at most 10 s, and other axes, need a log-likelihood ratio of
/// at least 20 over none; returns nothing unless the speeds correlate by at least 0.6.
std::optional<GyroComparison> compare_gyro(const std::vector<TimedRotation>& gyro,
                                           const std::vector<files::TumRow>& truth,
                                           const Eigen::Matrix3d& R_GT = Eigen::Matrix3d::Identity());

/// Returns "x, -y, z" for axes.
std::string axes_text(const std::array<FollowedAxis, 3>& axes);

}  // namespace sim::recording
