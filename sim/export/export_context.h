// The parts that all exporters share: the run's sensors and their readings, its lens for programs that do not
// know it, the way files are written, and the functions that write one format each.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/export/export.h"
#include "sim/export/exported_camera.h"
#include "sim/export/imu_merger.h"
#include "sim/files/trajectory_file.h"
#include "sim/recording/filter_input.h"
#include "sim/recording/sensor_yaml.h"
#include "sim/rig/rig.h"
#include "slam/options.h"

namespace sim::exports {

inline constexpr double kLeastGyroWalk = 1e-6;  // rad/s²/√Hz, m/s³/√Hz: programs divide by these
inline constexpr double kLeastAccelerometerWalk = 1e-5;

/// The noise of an IMU as densities: a mean over dt has the standard deviation density/√dt. No number is 0,
/// because programs divide by them.
inline recording::ImuNoise noise_of(const rig::RigSensor& imu) {
  const double root_period = std::sqrt(1 / imu.rate_hz);
  return {std::max(kLeastGyroWalk, imu.gyro_sigma_rad_s * root_period),
          std::max(kLeastGyroWalk, imu.gyro_bias_walk_rad_s2),
          std::max(kLeastAccelerometerWalk, imu.accelerometer_sigma_m_s2 * root_period),
          std::max(kLeastAccelerometerWalk, imu.accelerometer_bias_walk_m_s3)};
}

/// Returns the file of that name in texts/, which the program embeds.
std::string text_of(std::string_view name);

/// The readings of all sensors and the plan that the filter gets with a frame.
struct ExportedFrame {
  slam::Stamp t{0};
  std::optional<slam::PlannedMotion> plan;
  std::vector<ExportedReading> readings;  ///< first those of the chest IMU, then the image of the head camera
};

/// A run that is being exported into `folder`. Throws FileError.
class ExportContext {
 public:
  /// undistort: export images of a pinhole; otherwise the recorded ones, of a camera with the equidistant
  /// lens. passes: how often Frames will be read to their end.
  ExportContext(const ExportedRun& run, const std::filesystem::path& folder, bool undistort, int passes = 1);

  const ExportedRun& run;
  const std::filesystem::path folder;
  const recording::RecordingSetup setup;  ///< as recorded
  /// The sensors as exported, with their errors: those of the rig, then head camera and chest IMU.
  std::vector<rig::RigSensor> sensors;

  const rig::RigSensor& sensor(int index) const { return sensors.at(static_cast<std::size_t>(index)); }
  int head() const { return static_cast<int>(setup.rig.size()); }
  int chest() const { return head() + 1; }
  /// Returns the indices of a kind, starting with the head camera or the chest IMU. Folders and topics of
  /// some formats count them: cam0, cam1; imu0, imu1.
  std::vector<int> all(rig::Kind kind) const;
  /// Returns the pose of the sensor in the body frame, which is that of the chest IMU.
  Eigen::Isometry3d X_GS(int index) const;

  /// Returns the truth, empty in an export without truth.
  recording::Truth truth() const {
    return run.with_truth ? recording::read_truth(run.result / "recording") : recording::Truth();
  }
  /// Returns the true motion of the chest IMU in EuRoC's columns.
  std::string motion() const;
  /// Returns the filter's X_WC; empty without a filter and in an export without truth.
  std::vector<files::TumRow> estimate() const;

  /// Creates the folders of a file to be written and returns its path.
  std::filesystem::path new_file(const std::string& name) const;
  /// Writes a whole file.
  void write(const std::string& name, std::string_view bytes) const;
  /// write() of true poses; does nothing in an export without truth.
  void write_truth(const std::string& name, std::string_view bytes) const {
    if (run.with_truth) write(name, bytes);
  }
  /// Writes README.md: the texts of these names, `more`, and the conventions of all exports. cameras: those
  /// whose images are exported.
  void write_readme(std::initializer_list<std::string> names, const std::vector<int>& cameras,
                    const std::string& more = "") const;

 private:
  friend class Frames;
  std::string cameras_text(const std::vector<int>& cameras) const;

  const bool undistort_;
  const int passes_;
  mutable int passed_ = 0;
  std::vector<std::optional<ExportedCamera>> cameras_;  // by sensor
};

/// The frames from the start of the run, in order of time.
class Frames {
 public:
  explicit Frames(const ExportContext& out)
      : out_(out),
        input_(out.run.result / "recording", out.run.errors, out.run.seed),
        imu_(out.setup.imu_rate_hz) {}
  /// Returns the next frame, or nothing after the last.
  std::optional<ExportedFrame> next();

 private:
  const ExportContext& out_;
  recording::FilterInput input_;
  ImuMerger imu_;
};

/// Returns the camera whose images belong to the depth images of a camera: the color camera that it is
/// aligned with, else the color camera that sees most of the same, else the gray camera that it is aligned
/// with.
int image_of_depth(const ExportContext& out, int depth);

/// Writes a ROS 2 bag, run.mcap and metadata.yaml, into a folder with a trailing slash, or "". for_viewers:
/// all sensors, images as PNG, frames, paths, map, joints and feet; else raw images of the gray cameras and
/// readings of the IMUs.
void write_ros_bag(const ExportContext& out, const std::string& folder, bool for_viewers);

void export_euroc(const ExportContext& out);     ///< the EuRoC/ASL layout
void export_orbslam3(const ExportContext& out);  ///< the same with the settings of ORB-SLAM3
void export_openvins(const ExportContext& out);  ///< a bag and the EuRoC/ASL layout with OpenVINS's settings
void export_mcap(const ExportContext& out);      ///< a bag for viewers
void export_tum(const ExportContext& out);       ///< the TUM RGB-D layout, with undistorted images

}  // namespace sim::exports
