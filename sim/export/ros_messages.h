// ROS 2 messages in CDR, and their definitions for files that carry them.
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/export/imu_merger.h"
#include "sim/export/mcap.h"
#include "sim/files/trajectory_file.h"
#include "slam/options.h"

namespace sim::exports::ros {

extern const MessageType kCompressedImage, kImage, kImu, kCameraInfo, kPoseStamped,
    kPoseWithCovarianceStamped, kTransforms, kPath, kPointCloud, kJointState, kWrench, kString;

/// Messages are bytes; their stamps are recording::kEpoch later than t.
std::string compressed_image(slam::Stamp t, const std::string& frame, std::string_view png);
std::string image(slam::Stamp t, const std::string& frame, const cv::Mat& grey);
/// The sensor_msgs/Imu of a reading without orientation; variances are those of one reading.
std::string imu(const ImuReading& reading, const std::string& frame, double gyro_variance,
                double accelerometer_variance);
/// The equidistant lens is stated; any other counts as no distortion.
std::string camera_info(slam::Stamp t, const std::string& frame, const slam::CameraIntrinsics& camera);
std::string pose_stamped(slam::Stamp t, const std::string& frame, const Eigen::Isometry3d& X);
/// P: of (orientation in the camera's axes, position in the world's), as slam::Estimate; the message has the
/// position first and the rotation about the world's axes.
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
std::string path(slam::Stamp t, const std::string& frame, std::span<const files::TimedPose> poses);

/// A point and its identifier.
struct CloudPoint {
  Eigen::Vector3d p;
  std::uint32_t id = 0;
};
/// Fields x, y, z (float32) and id (uint32).
std::string point_cloud(slam::Stamp t, const std::string& frame, const std::vector<CloudPoint>& points);
/// Only positions, rad.
std::string joint_state(slam::Stamp t, const std::vector<std::string>& names,
                        const std::vector<double>& positions);
std::string wrench(slam::Stamp t, const std::string& frame, const Eigen::Vector3d& force_n,
                   const Eigen::Vector3d& torque_nm);

}  // namespace sim::exports::ros
