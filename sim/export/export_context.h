// Shared by all exporters: the run's sensors and their readings, a substitute for its lens in programs that
// do not support it, the writing of files, and a function for each format.
#pragma once

#include <fmt/format.h>

#include <cmath>

#include "sim/export/export.h"
#include "sim/recording/sensor_yaml.h"
#include "slam/camera.h"

namespace sim::exports {

class ExportContext;

/// "1000000000.033000000"
inline std::string written_seconds(slam::Stamp t) {
  return fmt::format("{}.{:09}", recording::file_stamp(t) / 1'000'000'000,
                     recording::file_stamp(t) % 1'000'000'000);
}

/// The fewest digits that round-trip, with a decimal point: some readers reject the integer 1.
inline std::string real(double x) {
  const std::string text = fmt::format("{}", x);
  return text.find_first_of(".e") == text.npos ? text + ".0" : text;
}

/// Four rows of four numbers, each row between `before` and `after`, `between` them: "[1.0, 0.0, ...]\n[...".
inline std::string matrix_text(const Eigen::Isometry3d& X, std::string_view before, std::string_view after,
                               std::string_view between) {
  std::string text;
  for (int row = 0; row < 4; ++row)
    text += fmt::format("{}{}{}, {}, {}, {}{}", row ? between : "", before, real(X(row, 0)), real(X(row, 1)),
                        real(X(row, 2)), real(X(row, 3)), after);
  return text;
}

/// Returns "t tx ty tz qx qy qz qw" with the stamps of the exports.
inline std::string tum_text(const std::vector<files::TimedPose>& poses) {
  std::string text;
  for (const files::TimedPose& pose : poses) text += files::tum_row(recording::kEpoch + pose.t, pose.X);
  return text;
}

/// The motion of a recorded walk, from data that the program under test also has.
struct WalkMotion {
  std::vector<double> speeds_m_s;   ///< planned speeds of the moving camera, from frame to frame
  std::vector<double> turns_rad_s;  ///< rates of the chest gyro
};

/// Returns the value at this fraction (0 to 1) of the sorted values, or 0 if there are none.
double percentile(std::vector<double> values, double fraction);

/// The images that OpenVINS tracks.
struct TrackedImages {
  int every;            ///< one image in so many
  double frequency_hz;  ///< for OpenVINS, which drops images less than a period after the last one
};
/// OpenVINS's window of 11 images should span 0.15 m of the walk. Between two images, 90 % of the turns
/// should move corners by at most a tenth of the image's width, because optical flow follows only small
/// steps.
TrackedImages tracked_images(const slam::CameraIntrinsics& camera, double rate_hz, const WalkMotion& motion);

/// Writes mav0/ in the EuRoC/ASL layout, times.txt, and, for two gray cameras, times_stereo.txt with the
/// stamps that both have. images_within_imu: leaves out images before the first IMU reading and after the
/// last one.
WalkMotion write_mav0(const ExportContext& out, bool images_within_imu = false);

/// Returns whether the second gray camera sees enough of the head camera's view to be its stereo partner.
/// Warns if there is a second camera that does not see enough.
bool has_stereo(const ExportContext& out);

/// Returns settings of ORB-SLAM3 (v1.0) for a camera's images. Settings for the head camera include the IMU
/// and, if there is a stereo pair, stereo. depth: a depth camera registered to the camera, for settings
/// without IMU.
std::string orbslam3_settings(const ExportContext& out, int camera, std::optional<int> depth, bool inertial);

/// A reading in its exported form. An image is converted to the exported camera. An IMU reading is the mean
/// of an interval, stamped in its middle; it differs from the value at that instant only in second order of
/// the interval's length.
struct ExportedReading : slam::RigReading {
  bool has_acceleration = true;
};

/// Merges consecutive parts until they cover one period. It starts over after a gap in the readings.
class ImuMerger {
 public:
  explicit ImuMerger(double rate_hz) : period_(std::llround(1e9 / rate_hz)) {}
  /// Returns the readings that an observation completes, in chronological order.
  std::vector<ExportedReading> merge(const slam::Observation& observation) {
    std::vector<ExportedReading> merged;
    const bool both = observation.accelerometer.size() == observation.gyro.size();
    const auto start_at = [this](slam::Stamp t) {
      begin_ = t;
      gyro_.setZero();
      accelerometer_.setZero();
    };
    for (std::size_t i = 0; i < observation.gyro.size(); ++i) {
      const slam::InertialSample& gyro = observation.gyro[i];
      if (gyro.begin != end_) start_at(gyro.begin);
      const double dt = slam::seconds(gyro.end - gyro.begin);
      gyro_ += dt * gyro.value;
      if (both) accelerometer_ += dt * observation.accelerometer[i].value;
      end_ = gyro.end;
      if (end_ - begin_ < period_) continue;
      const double duration = slam::seconds(end_ - begin_);
      ExportedReading& reading = merged.emplace_back();
      reading.t = begin_ + (end_ - begin_) / 2, reading.gyro = gyro_ / duration;
      reading.accelerometer = accelerometer_ / duration, reading.has_acceleration = both;
      start_at(end_);
    }
    return merged;
  }

 private:
  slam::Stamp period_, begin_{0}, end_{0};
  Eigen::Vector3d gyro_ = Eigen::Vector3d::Zero(), accelerometer_ = Eigen::Vector3d::Zero();  // ∫ dt
};

/// Returns the coefficients of an exported camera's equidistant lens, or nothing for a pinhole without
/// distortion.
inline std::optional<std::array<double, 4>> equidistant_lens(const slam::CameraIntrinsics& camera) {
  const auto* k = std::get_if<slam::Equidistant>(&camera.lens);
  return k ? std::optional(std::array{k->k1, k->k2, k->k3, k->k4}) : std::nullopt;
}

/// Removes the lens distortion from images.
class Undistortion {
 public:
  /// The pinhole (radial-tangential without distortion) has square pixels and the given camera's size and
  /// principal point. Its focal length is the smallest whole number that keeps all its pixels inside the
  /// image.
  explicit Undistortion(const slam::CameraIntrinsics& camera);
  const slam::CameraIntrinsics& pinhole() const { return pinhole_; }
  /// Returns the pinhole's image, by bilinear interpolation or, for 16 bits, from the nearest pixel. `image`
  /// has the given camera's size.
  cv::Mat operator()(const cv::Mat& image) const;

 private:
  slam::CameraIntrinsics pinhole_;
  std::vector<Eigen::Vector2d> from_;  // where each pixel is in the given image, row by row
};

/// The exported form of a camera and its images.
struct ExportedCamera {
  /// undistort: as a pinhole, otherwise with the equidistant lens. A camera without distortion stays as it
  /// is.
  ExportedCamera(const slam::CameraIntrinsics& recorded, bool undistort);
  rig::FittedCamera fitted;
  std::optional<Undistortion> undistortion;
};

/// Renders the depth images (mm, 0: none) of one camera as seen by another.
class DepthRegistration {
 public:
  /// X_to_from: from one camera to the other.
  DepthRegistration(const slam::CameraIntrinsics& from, const slam::CameraIntrinsics& to,
                    const Eigen::Isometry3d& X_to_from);
  /// Each pixel covers the projection of its square; the nearest surface wins. Gaps of one pixel within a
  /// surface are filled.
  cv::Mat1w operator()(const cv::Mat1w& depth_mm) const;

 private:
  struct Square {
    Eigen::Vector3d center, first, last;  // sight lines (z = 1) of a pixel and of two opposite corners
  };
  slam::Camera to_;
  cv::Size size_;
  Eigen::Isometry3d X_to_from_;
  std::vector<std::optional<Square>> squares_;  // squares of the given camera's pixels, row by row
};

/// Returns the fraction of the camera's image that the other one also sees at a distance (m).
double overlap(const rig::RigSensor& camera, const rig::RigSensor& other, double distance_m);

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

/// Returns the text below the line `@@ name` of texts.txt, which the program embeds.
std::string text_of(std::string_view name);
/// Returns text_of() as a format with its values.
template <typename... T>
std::string filled_text(std::string_view name, const T&... values) {
  return fmt::format(fmt::runtime(text_of(name)), values...);
}

/// The readings of all sensors that the filter gets with a frame.
struct ExportedFrame {
  slam::Stamp t{0};
  slam::Observation motion;               ///< only its plan, leg odometry and command
  std::vector<ExportedReading> readings;  ///< the chest IMU's first, then the head camera's image
};

/// A run while it is exported into `folder`. Throws FileError.
class ExportContext {
 public:
  /// undistort: exports pinhole images; otherwise the recorded images, of a camera with the equidistant lens.
  /// passes: how often Frames will be read to the end.
  ExportContext(const ExportedRun& run, const fs::path& folder, bool undistort, int passes = 1);

  const ExportedRun& run;
  const fs::path folder;
  const recording::RecordingSetup setup;  ///< as recorded
  /// The sensors as exported, with their errors: the rig's, then the head camera and the chest IMU.
  std::vector<rig::RigSensor> sensors;

  const rig::RigSensor& sensor(int index) const { return sensors.at(std::size_t(index)); }
  int head() const { return int(setup.rig.size()); }
  int chest() const { return head() + 1; }
  /// Returns the indices of the sensors of a kind, starting with the head camera or the chest IMU. Some
  /// formats number folders and topics in this order: cam0, cam1; imu0, imu1.
  std::vector<int> all(rig::Kind kind) const;
  /// Returns the pose of the sensor in the body frame, which is the chest IMU's.
  Eigen::Isometry3d X_GS(int index) const;

  /// Returns the truth. It is empty in an export without truth.
  recording::Truth truth() const {
    return run.with_truth ? recording::read_truth(run.result / "recording") : recording::Truth();
  }
  /// Returns the true motion of the chest IMU in EuRoC's columns.
  std::string motion() const;
  /// Returns the filter's X_WC. It is empty without a filter and in an export without truth.
  std::vector<files::TumRow> estimate() const;

  /// Creates the folders for a file to be written and returns the file's path.
  fs::path new_file(const std::string& name) const;
  /// Writes a whole file.
  void write(const std::string& name, std::string_view bytes) const;
  /// Writes true poses as write() does; does nothing in an export without truth.
  void write_truth(const std::string& name, std::string_view bytes) const {
    if (run.with_truth) write(name, bytes);
  }
  /// Writes README.md: the texts of these names, `more`, and the conventions of all exports. cameras: the
  /// exported ones.
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

/// The frames from the start of the run, in chronological order.
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

/// Returns the camera whose images are paired with the depth images: the color camera aligned with `depth`,
/// otherwise the color camera with the largest common view, otherwise the gray camera aligned with it.
int image_of_depth(const ExportContext& out, int depth);

/// Writes a ROS 2 bag, run.mcap and metadata.yaml, into a folder (with a trailing slash, or ""). for_viewers:
/// all sensors, images as PNG, frames, paths, map, joints and feet; otherwise only raw images of the gray
/// cameras and readings of the IMUs.
void write_ros_bag(const ExportContext& out, const std::string& folder, bool for_viewers);

void export_euroc(const ExportContext& out);     ///< the EuRoC/ASL layout
void export_orbslam3(const ExportContext& out);  ///< the same with settings for ORB-SLAM3
void export_openvins(const ExportContext& out);  ///< a bag and the EuRoC/ASL layout, with OpenVINS settings
void export_mcap(const ExportContext& out);      ///< a bag for viewers
void export_tum(const ExportContext& out);       ///< the TUM RGB-D layout, with undistorted images

}  // namespace sim::exports
