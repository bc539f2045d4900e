// ROS 2 messages in CDR, and their definitions for files that carry them.
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/export/imu_merger.h"
#include "sim/export/mcap.h"
#include "sim/files/tum.h"
#include "slam/options.h"

namespace sim::exports::ros {

extern const MessageType kCompressedImage, kImage, kImu, kCameraInfo, kPoseStamped,
    kPoseWithCovarianceStamped;

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

}  // namespace sim::exports::ros
