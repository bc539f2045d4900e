// An external recording in the EuRoC/ASL layout (README.md): one camera and a gyro; accelerometer, walking
// plan and truth if present. Times start at the first image.
#pragma once

#include "sim/files/trajectory_file.h"
#include "sim/recording/sensor_yaml.h"
#include "slam/observation.h"

namespace sim::recording {

/// The sensors of an external recording. Without plan0, setup.X_WC_start is the first pose of legs0. Without
/// either, the world has its origin at the first camera, and its z axis is up according to the first
/// accelerometer readings, if any.
struct AslSensors {
  RecordingSetup setup;
  ImuNoise noise;  ///< zero if not stated
  Eigen::Isometry3d X_BC = Eigen::Isometry3d::Identity();
  bool has_motion = false;           ///< a plan, leg odometry or a command
  slam::Stamp first_image{0};        ///< on the camera's clock
  slam::Stamp imu_ahead{0};          ///< timeshift_cam_imu, subtracted from the IMU's stamps
  std::vector<std::string> remarks;  ///< "FILE: ignored keys: ...", for the user
};

/// Reads the observations one after another. The constructor checks calibration, rates and clocks, the
/// headers of all images, and the gyro against the truth. For missing or malformed data, throws FileError
/// with file, line and column.
class AslFolder {
 public:
  explicit AslFolder(const fs::path& folder);
  ~AslFolder();

  const fs::path& folder() const;
  const AslSensors& sensors() const;
  /// Returns the times of all images, counted from the first one.
  const std::vector<slam::Stamp>& times() const;
  /// Returns the true camera poses X_WC. They are interpolated linearly at image times between true poses
  /// less than 0.1 s apart, and the first is aligned with setup.X_WC_start. If the truth has only positions
  /// (Truth::positions_of), they are positions of its point in its own world. Empty without truth.
  const Truth& truth() const;
  /// Returns the next image with the readings since the previous image, or nothing after the last. A reading
  /// applies up to halfway to its neighbors.
  std::optional<slam::Observation> next();
  /// Returns the progress of next(), 0 to 1.
  double part() const;

 private:
  struct Files;
  std::unique_ptr<Files> files_;
};

/// Returns whether a folder has this layout.
bool is_asl_folder(const fs::path& folder);

/// A gyro reading.
struct TimedRotation {
  slam::Stamp t{0};
  Eigen::Vector3d value;  ///< rad/s
};

struct GyroComparison {
  double late_s;                   ///< the gyro's stamps minus the truth's; 0 without evidence
  double correlation, as_stamped;  ///< correlation of the rotation speeds: at this offset; without an offset
  double gain;                     ///< the gyro's speeds relative to the truth's
  bool mirrored = false;           ///< only a rotation of the body's mirror image explains the gyro
  std::optional<double> turned_rad = {};  ///< angle between their axes; absent unless decisively nonzero
};

/// Compares a gyro with the truth of the first hour by their turns over 0.1 s, without bias. R_GT: from the
/// truth's axes to the gyro's. An offset (at most 10 s) or different axes are only reported if
/// their log-likelihood ratio to no change is at least 20. Returns nothing unless the speeds correlate by at
/// least 0.6.
std::optional<GyroComparison> compare_gyro(const std::vector<TimedRotation>& gyro,
                                           const std::vector<files::TumRow>& truth,
                                           const Eigen::Matrix3d& R_GT = Eigen::Matrix3d::Identity());

}  // namespace sim::recording
