// ROS 2 messages in CDR with their definitions.
#pragma once

#include <span>

#include "sim/export/export_context.h"

namespace sim::exports {

/// The type of a channel's messages: the name of its schema, and its definition in ROS 2's interface
/// language.
struct MessageType {
  std::string name, definition;
};

namespace ros {

/// Frames of the head camera (axes: x right, y down, z forward) and of the chest IMU.
inline constexpr const char *kCameraFrame = "cam0_optical_frame", *kImuFrame = "imu";

/// Topics of bags and of the live view: prefixes for the source, suffixes for the content.
inline const std::string kHeadTopics = "/camera", kTrueTopics = "/ground_truth", kPlanTopics = "/plan",
                         kSlamTopics = "/slam", kImageTopic = "/image/compressed",
                         kInfoTopic = "/camera_info", kImuTopic = "/imu", kPoseTopic = "/pose";

extern const MessageType kCompressedImage, kImage, kImu, kCameraInfo, kPoseStamped,
    kPoseWithCovarianceStamped, kTransforms, kPath, kPointCloud, kJointState, kWrench, kString;

/// Returns the message as bytes, as do all functions below. Its stamps are t plus recording::kEpoch.
std::string compressed_image(slam::Stamp t, const std::string& frame, std::string_view png);
/// Returns the sensor_msgs/Image of 8-bit gray (mono8), RGB (rgb8) or depth in mm (16UC1).
std::string image(slam::Stamp t, const std::string& frame, const cv::Mat& image);
/// Returns the sensor_msgs/Imu of a reading, without orientation. The variances apply to a single reading.
std::string imu(const ExportedReading& reading, const std::string& frame, double gyro_variance,
                double accelerometer_variance);
/// Returns the sensor_msgs/CameraInfo. It states an equidistant lens; any other lens counts as no distortion.
/// right_m: distance of the camera to the right of the other one of a stereo pair; P[3] is -fu right_m.
std::string camera_info(slam::Stamp t, const std::string& frame, const slam::CameraIntrinsics& camera,
                        double right_m = 0);
/// Returns the geometry_msgs/PoseStamped of a pose X in `frame`.
std::string pose_stamped(slam::Stamp t, const std::string& frame, const Eigen::Isometry3d& X);
/// Returns the message, with the position first and the rotation about the world's axes. P: covariance of
/// (orientation in the camera's axes, position in the world's), as in slam::Estimate.
std::string pose_with_covariance_stamped(slam::Stamp t, const std::string& frame, const Eigen::Isometry3d& X,
                                         const files::Matrix6d& P);

std::string string(const std::string& text);

/// The pose of a frame in its parent frame.
struct Transform {
  slam::Stamp t{0};
  std::string parent, child;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
};
/// Returns the tf2_msgs/TFMessage.
std::string transforms(const std::vector<Transform>& all);
/// Returns the nav_msgs/Path of poses in `frame`.
std::string path(slam::Stamp t, const std::string& frame, std::span<const files::TumRow> poses);

/// A point and its identifier.
struct CloudPoint {
  float x_m, y_m, z_m;
  std::uint32_t id;
};
/// Returns a cloud with the fields x, y, z (float32) and id (uint32).
std::string point_cloud(slam::Stamp t, const std::string& frame, const std::vector<CloudPoint>& points);
/// Rings of a lidar: rows of equal height in elevation, the lowest is 0.
inline constexpr int kRings = 64;
/// Returns a cloud with the fields x, y, z, intensity (float32), t (uint32, ns since the stamp) and ring
/// (uint8), as expected by programs for Ouster's lidars. lowest_rad, highest_rad: the lidar's range of
/// elevations.
std::string point_cloud(slam::Stamp t, const std::string& frame, const std::vector<slam::LidarPoint>& points,
                        double lowest_rad, double highest_rad);
/// Returns a joint state with positions (rad) only.
std::string joint_state(slam::Stamp t, const std::vector<std::string>& names,
                        const std::vector<double>& positions);
/// Returns the geometry_msgs/WrenchStamped of a force (N) and a torque (N·m) in the axes of `frame`.
std::string wrench(slam::Stamp t, const std::string& frame, const Eigen::Vector3d& force_n,
                   const Eigen::Vector3d& torque_nm);

}  // namespace ros
}  // namespace sim::exports
