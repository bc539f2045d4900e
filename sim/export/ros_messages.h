// ROS 2 messages in CDR with their definitions, the IMU readings in them, and MCAP files of messages
// (mcap.dev, version 0 of the format): chunked, indexed, with a checksum of each chunk, not compressed.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <numeric>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/files/hash.h"
#include "sim/files/trajectory_file.h"
#include "slam/observation.h"
#include "slam/options.h"

namespace sim::exports {

/// Returns the file of that name in texts/, which the program embeds.
std::string text_of(std::string_view name);

/// A reading in its exported form: the image of the exported camera; one of an IMU is the mean of an
/// interval, stamped in its middle. It differs from the value at that instant by terms of second order in the
/// length of the interval.
struct ExportedReading : slam::RigReading {
  bool has_acceleration = true;
};

/// Merges consecutive parts until they cover one period. After a gap in the readings it starts anew.
class ImuMerger {
 public:
  explicit ImuMerger(double rate_hz) : period_(std::llround(1e9 / rate_hz)) {}
  /// Returns the readings that an observation completes, in order of time.
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

/// The type of a channel's messages: the name of its schema and the definition in ROS 2's interface language.
struct MessageType {
  std::string name, definition;
};

/// A file of ROS 2 messages in CDR. Memory: one chunk and the indexes. Throws FileError.
class McapWriter {
 public:
  explicit McapWriter(const std::filesystem::path& file);

  /// Adds a channel before the first message; returns its number. qos: publisher's profiles in YAML or empty.
  std::uint16_t add_channel(const std::string& topic, const MessageType& type, const std::string& qos);
  void add_message(std::uint16_t channel, std::int64_t t_ns, std::string_view cdr);
  /// Writes the indexes and closes the file. Without them it is not a valid MCAP file.
  void finish();

  std::uint64_t messages() const { return std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0}); }
  std::uint64_t messages(std::uint16_t channel) const { return counts_.at(channel - 1u); }
  std::uint64_t begin_ns() const { return begin_; }
  std::uint64_t end_ns() const { return end_; }

 private:
  struct Chunk {  // its index
    std::uint64_t begin, end, offset, length, index_length, size;
    std::map<std::uint16_t, std::uint64_t> index_offsets;
  };
  using Moments = std::vector<std::pair<std::uint64_t, std::uint64_t>>;  // time, offset in the chunk

  void put(std::string_view bytes);
  void close_chunk();

  files::HashedFile out_;
  std::uint64_t at_ = 0;
  std::vector<std::string> schemas_, channels_;  // their records
  std::vector<std::uint64_t> counts_;            // of each channel
  std::vector<Chunk> chunks_;
  std::string chunk_;
  std::map<std::uint16_t, Moments> moments_;
  std::uint64_t chunk_begin_ = ~0ull, chunk_end_ = 0, begin_ = ~0ull, end_ = 0;
};

namespace ros {

/// Frames of the head camera (axes: x right, y down, z forward) and of the chest IMU.
inline constexpr const char *kCameraFrame = "cam0_optical_frame", *kImuFrame = "imu";

extern const MessageType kCompressedImage, kImage, kImu, kCameraInfo, kPoseStamped,
    kPoseWithCovarianceStamped, kTransforms, kPath, kPointCloud, kJointState, kWrench, kString;

/// Returns the message as bytes, as do all functions below; its stamps are recording::kEpoch later than t.
std::string compressed_image(slam::Stamp t, const std::string& frame, std::string_view png);
/// Returns the sensor_msgs/Image of 8-bit gray (mono8), RGB (rgb8) or depth in mm (16UC1).
std::string image(slam::Stamp t, const std::string& frame, const cv::Mat& image);
/// Returns the sensor_msgs/Imu of a reading without orientation; variances are those of one reading.
std::string imu(const ExportedReading& reading, const std::string& frame, double gyro_variance,
                double accelerometer_variance);
/// Returns the sensor_msgs/CameraInfo. It states the equidistant lens; any other counts as no distortion.
/// right_m: distance of the camera to the right of the other one of a stereo pair; P[3] is -fu right_m.
std::string camera_info(slam::Stamp t, const std::string& frame, const slam::CameraIntrinsics& camera,
                        double right_m = 0);
std::string pose_stamped(slam::Stamp t, const std::string& frame, const Eigen::Isometry3d& X);
/// Returns the message with the position first and the rotation about the world's axes. P: of (orientation in
/// the camera's axes, position in the world's), as in slam::Estimate.
std::string pose_with_covariance_stamped(slam::Stamp t, const std::string& frame, const Eigen::Isometry3d& X,
                                         const files::Matrix6d& P);

std::string string(const std::string& text);

/// The pose of a frame in its parent frame.
struct Transform {
  slam::Stamp t{0};
  std::string parent, child;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
};
std::string transforms(const std::vector<Transform>& all);
std::string path(slam::Stamp t, const std::string& frame, std::span<const files::TumRow> poses);

/// A point and its identifier.
struct CloudPoint {
  float x_m, y_m, z_m;
  std::uint32_t id;
};
/// Returns a cloud with the fields x, y, z (float32) and id (uint32).
std::string point_cloud(slam::Stamp t, const std::string& frame, const std::vector<CloudPoint>& points);
/// Returns a cloud with the fields x, y, z, intensity (float32) and t (uint32, ns since the stamp), as
/// FAST-LIO, KISS-ICP and LIO-SAM read from Ouster's lidars.
std::string point_cloud(slam::Stamp t, const std::string& frame, const std::vector<slam::LidarPoint>& points);
/// Returns a joint state with positions (rad) only.
std::string joint_state(slam::Stamp t, const std::vector<std::string>& names,
                        const std::vector<double>& positions);
std::string wrench(slam::Stamp t, const std::string& frame, const Eigen::Vector3d& force_n,
                   const Eigen::Vector3d& torque_nm);

}  // namespace ros
}  // namespace sim::exports
