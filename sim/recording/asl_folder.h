// An external recording in the EuRoC/ASL layout (README.md): one camera and a gyro; accelerometer, walking
// plan and truth if present. Times count from the first image.
#pragma once

#include "sim/recording/sensor_yaml.h"

namespace sim::recording {

/// The sensors of an external recording. Without a plan the world of setup.X_WC_start has its origin at the
/// first camera; its z axis is up according to the first accelerometer readings, if any.
struct AslSensors {
  RecordingSetup setup;
  ImuNoise noise;  ///< zero if not stated
  Eigen::Isometry3d X_BC = Eigen::Isometry3d::Identity();
  bool has_plan = false;
  slam::Stamp first_image{0};        ///< by the camera's clock
  slam::Stamp imu_ahead{0};          ///< timeshift_cam_imu, subtracted from the stamps of the IMU
  std::vector<std::string> remarks;  ///< "FILE: keys that are not read: ..."
};

/// Reads the observations one after another. Throws FileError with file, line and column of missing or
/// malformed data. The constructor checks calibration, the list of images, the rates and the clocks.
class AslFolder {
 public:
  explicit AslFolder(const std::filesystem::path& folder);
  ~AslFolder();

  const AslSensors& sensors() const;
  /// Returns the times of all images, from the first one on.
  const std::vector<slam::Stamp>& times() const;
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
bool is_asl_folder(const std::filesystem::path& folder);

/// Returns true camera poses X_WC, interpolated linearly, at those of the rising times between true poses
/// less than 0.1 s apart; empty without truth. The first pose is aligned with AslSensors::setup.X_WC_start.
/// For a truth of positions only (Truth::positions_of) they are positions of its point in its own world.
/// Throws FileError, also if no true pose is near any of the times, or if clock_offset() finds 0.1 s or more
/// between gyro and truth.
Truth read_asl_truth(const std::filesystem::path& folder, const AslSensors& sensors,
                     const std::vector<slam::Stamp>& times);

/// A reading of a gyro.
struct TimedRotation {
  slam::Stamp t{0};
  Eigen::Vector3d value;  ///< rad/s
};

struct ClockOffset {
  double late_s;                   ///< stamps of the gyro minus those of the truth; 0 without evidence
  double correlation, as_stamped;  ///< of the speeds of rotation, at this offset and at none
  double gain;                     ///< the gyro's speeds relative to those of the truth
};

/// Returns the offset, or nothing unless the speeds of rotation in the first hour correlate by at least 0.6
/// at an offset of at most 10 s. It is evidence if it explains them decisively better than none: by a
/// log-likelihood ratio of the two linear relations of at least 15, if speeds over 0.1 s are independent. The
/// axes of the two bodies and a bias do not matter.
std::optional<ClockOffset> clock_offset(const std::vector<TimedRotation>& gyro,
                                        const std::vector<files::TumRow>& truth);

}  // namespace sim::recording
