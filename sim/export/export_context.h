// The parts that all exporters share: the run's sensors and observations, its lens for programs that do not
// know it, the way files are written, and the functions that write one format each.
#pragma once

#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/export/export.h"
#include "sim/files/trajectory_file.h"
#include "sim/recording/filter_input.h"
#include "sim/recording/sensor_yaml.h"
#include "sim/rig/equidistant_fit.h"
#include "slam/options.h"

namespace sim::exports {

/// Removes the lens distortion from images.
class Undistortion {
 public:
  /// The pinhole (radial-tangential without distortion) has square pixels and the given camera's size and
  /// principal point. Its focal length is the least whole number that keeps all its pixels inside.
  explicit Undistortion(const slam::CameraIntrinsics& camera);
  const slam::CameraIntrinsics& pinhole() const { return pinhole_; }
  /// The pinhole's image by bilinear interpolation, of 16 bits by the nearest pixel; `image` has the given
  /// camera's size.
  cv::Mat operator()(const cv::Mat& image) const;

 private:
  slam::CameraIntrinsics pinhole_;
  std::vector<Eigen::Vector2d> from_;  // the place of each pixel in the given image, row by row
};

/// The exported form of a camera and its images.
struct ExportedCamera {
  /// undistort: as a pinhole, otherwise with the equidistant lens. One without distortion stays as it is.
  ExportedCamera(const slam::CameraIntrinsics& recorded, bool undistort);
  rig::FittedCamera fitted;
  std::optional<Undistortion> undistortion;
};

/// The index of the head camera among the sensors of the rig.
inline constexpr int kHead = -1;

/// A run that is being exported into `folder`. Throws FileError.
class ExportContext {
 public:
  /// undistort: export images of a pinhole; otherwise the recorded ones, of a camera with the equidistant
  /// lens. passes: how often filter_input() will be read to its end.
  ExportContext(const ExportedRun& run, const std::filesystem::path& folder, bool undistort, int passes = 1);

  const ExportedRun& run;
  const std::filesystem::path folder;
  recording::RecordingSetup setup;  ///< its cameras are those of the exported images
  recording::ImuNoise noise;

  /// The observations from the start of the run, for next().
  recording::FilterInput filter_input() const { return {run.result / "recording", run.errors, run.seed}; }
  /// Returns the next observation in order of time, nothing after the last.
  std::optional<slam::Observation> next(recording::FilterInput& input) const {
    run.progress((passed_ + input.part()) / passes_);
    auto observation = input.next_in_order();
    if (!observation) ++passed_;
    return observation;
  }
  /// Empty in an export without truth.
  recording::Truth truth() const {
    return run.with_truth ? recording::read_truth(run.result / "recording") : recording::Truth();
  }
  /// The filter's X_WC; empty without a filter and in an export without truth.
  std::vector<files::TumRow> estimate() const;
  const slam::CameraIntrinsics& camera() const { return setup.calibration.camera; }
  /// The sensors of the rig of that kind, in order. Folders and topics of some formats count them: cam1,
  /// imu1.
  std::vector<int> further(rig::Kind kind) const;
  const rig::RigSensor& sensor(int index) const { return setup.rig.at(static_cast<std::size_t>(index)); }
  /// The exported form of an image of the filter's input; sensor: of the rig, or kHead.
  cv::Mat exported(const cv::Mat& image, int sensor = kHead) const;
  /// The noise of a further IMU.
  static recording::ImuNoise noise_of(const rig::RigSensor& imu);

  /// Creates the folders of a file to be written and returns its path.
  std::filesystem::path new_file(const std::string& name) const;
  /// Writes a whole file.
  void write(const std::string& name, std::string_view bytes) const;
  /// write() of true poses; does nothing in an export without truth.
  void write_truth(const std::string& name, std::string_view bytes) const {
    if (run.with_truth) write(name, bytes);
  }
  /// Writes exported(image, sensor).
  void write_png(const std::string& name, const cv::Mat& image, int sensor = kHead) const;
  /// Writes README.md: the text, then the conventions of all exports.
  void write_readme(const std::string& text) const;

 private:
  std::string lens_text() const;

  const bool undistort_;
  const int passes_;
  mutable int passed_ = 0;
  std::vector<std::pair<int, ExportedCamera>> cameras_;  // by sensor, the head camera first
};

/// "1000000000.033000000"
std::string written_seconds(slam::Stamp t);

/// The fewest digits that round-trip, with a decimal point: some readers reject the integer 1.
std::string real(double x);

/// Four rows of four numbers, each row between `before` and `after`, `between` them: "[1.0, 0.0, ...]\n[...".
std::string matrix_text(const Eigen::Isometry3d& X, std::string_view before, std::string_view after,
                        std::string_view between);

/// "t tx ty tz qx qy qz qw" with the stamps of the exports.
std::string tum_text(const std::vector<files::TimedPose>& poses);

/// The coefficients of an exported camera's equidistant lens; nothing for a pinhole without distortion.
std::optional<std::array<double, 4>> equidistant_lens(const slam::CameraIntrinsics& camera);

/// The frame of a sensor: optical axes (x right, y down, z forward) of a camera, else x forward, y left, z
/// up. Depth has that of the camera that it is aligned with.
std::string frame_of(const rig::RigSensor& sensor);

/// A depth image (mm, 0: none) as the camera `to` would have it, of pinholes. X_to_from: from one camera to
/// the other. Each pixel covers all that its square covers there; the nearest surface counts.
cv::Mat registered(const cv::Mat& depth, const slam::CameraIntrinsics& from, const slam::CameraIntrinsics& to,
                   const Eigen::Isometry3d& X_to_from);

/// A ROS 2 bag: run.mcap and metadata.yaml.
struct BagLayout {
  std::string folder;  ///< of run.mcap and metadata.yaml, with a trailing slash; may be empty
  std::string image_topic, info_topic, imu_topic;
  bool compressed;           ///< images as PNG (sensor_msgs/CompressedImage), else raw (sensor_msgs/Image)
  bool for_viewers = false;  ///< with all sensors of the rig, frames, paths, map, joints and feet
};
void write_ros_bag(const ExportContext& out, const BagLayout& layout);

/// Settings of ORB-SLAM3 (v1.0) for images of the head camera, with IMU and, if there are two gray eyes,
/// stereo.
std::string orbslam3_settings(const ExportContext& out);
/// Those for images of a camera, without IMU. depth: a depth camera aligned with it, or nothing.
std::string orbslam3_settings(const ExportContext& out, int camera, std::optional<int> depth);
/// Writes mav0/ in the EuRoC/ASL layout, times.txt, and for two gray eyes times_stereo.txt: the stamps that
/// both have. images_within_imu: without the images before the first reading and after the last one.
void write_mav0(const ExportContext& out, bool images_within_imu = false);

void export_euroc(const ExportContext& out);     ///< the EuRoC/ASL layout
void export_orbslam3(const ExportContext& out);  ///< the same with the settings of ORB-SLAM3
void export_openvins(const ExportContext& out);  ///< a bag and the EuRoC/ASL layout with OpenVINS's settings
void export_mcap(const ExportContext& out);      ///< a bag for viewers
void export_tum(const ExportContext& out);       ///< the TUM RGB-D layout, with undistorted images

}  // namespace sim::exports
