// What the exporters share: what is known of the run's sensors, and how files and settings are written.
#pragma once

#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/stream/export.h"
#include "sim/stream/other_lens.h"
#include "sim/stream/seen.h"
#include "sim/stream/sensor_yaml.h"
#include "sim/stream/whole_readings.h"

namespace sim::stream {

/// A run on its way out. `folder` is where the files go.
class Export {
 public:
  /// undistort: images as a pinhole would have seen them; else as they are, of a camera with the equidistant
  /// lens.
  Export(const ExportedRun& run, const std::filesystem::path& folder, bool undistort);

  const ExportedRun& run;
  const std::filesystem::path folder;
  RecordingSetup setup;  ///< the camera is the one that the images are said to be of: told_lens has its lens
  ImuNoise noise;

  /// The run from its beginning.
  Seen seen() const { return {run.result / "recording", run.errors, run.seed}; }
  Truth truth() const { return read_truth(run.result / "recording"); }
  /// X_WC as the filter had it; empty without a filter.
  std::vector<TumRow> estimate() const;
  const slam::CameraIntrinsics& camera() const { return setup.calibration.camera; }
  /// What the filter saw, as it is exported.
  cv::Mat image(const cv::Mat& seen) const { return undistorted_ ? (*undistorted_)(seen) : seen; }

  /// Writes a whole file, its folders made as needed.
  void write(const std::string& name, std::string_view bytes) const;
  /// image() of what the filter saw.
  void write_png(const std::string& name, const cv::Mat& seen) const;
  /// Writes README.md: the text, then what holds for every export.
  void write_readme(const std::string& text) const;

 private:
  /// "The lens is ... fitted to 0.07 px"
  std::string lens_text() const;

  FittedCamera equidistant_;
  std::optional<Undistorted> undistorted_;
};

/// A lens as other programs are told: equidistant, or without distortion.
struct ToldLens {
  bool equidistant;
  std::array<double, 4> k;  ///< all zero without distortion
};
ToldLens told_lens(const slam::CameraIntrinsics& camera);

/// "1000000000.033000000"
std::string written_seconds(slam::Stamp t);
/// The shortest decimals that bring the same bits back, with a decimal point: some readers take 1 for an
/// integer and refuse it.
std::string real(double x);
/// Four rows of four numbers, each row between these, the rows apart by `apart`: "[1.0, 0.0, ...]\n[...".
std::string matrix_text(const Eigen::Isometry3d& X, std::string_view before, std::string_view after,
                        std::string_view apart);
/// "t tx ty tz qx qy qz qw" with the stamps of the exports.
std::string tum_of(const std::vector<TimedPose>& poses);
/// The PNG's bytes.
std::vector<unsigned char> png(const cv::Mat& image);

/// ORB-SLAM3's settings of the camera; of the IMU; and the rest.
std::string orb_camera(const Export& out);
std::string orb_imu(const Export& out);
std::string orb_rest();

/// A ROS 2 bag: where it goes and what its topics are called.
struct Bag {
  std::string place;  ///< before run.mcap and metadata.yaml: "" or "bag/"
  std::string image_topic, info_topic, imu_topic;
  bool compressed;  ///< images as PNG (sensor_msgs/CompressedImage), or raw (sensor_msgs/Image)
};
void export_bag(const Export& out, const Bag& bag);

/// mav0/ in the EuRoC/ASL layout, and times.txt.
void export_mav0(const Export& out);

void export_euroc(const Export& out);
void export_tum(const Export& out);
void export_kitti(const Export& out);
void export_mcap(const Export& out);
void export_orbslam3(const Export& out);
void export_openvins(const Export& out);
void export_kalibr(const Export& out);

}  // namespace sim::stream
