// A frame of a run as pages and the view show it: the poses, the image, the filter's matches and its errors.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "sim/files/trajectory_file.h"
#include "sim/recording/recording.h"
#include "sim/score/trajectory.h"
#include "slam/frame_report.h"
#include "slam/observation.h"

namespace sim::pages {

inline constexpr double kSigmas = 3;  ///< size of every ellipse and ellipsoid

/// A foot on the ground.
struct FootPlace : recording::TrueFoot {
  std::optional<Eigen::Vector3d> landed{};  ///< place where it last landed; absent while in the air
  double slip_m = NAN;                      ///< distance from there; NaN in the air
};

/// Unknown parts are absent or empty.
struct Frame {
  slam::Stamp t{0};
  cv::Mat image = {};              ///< 8-bit gray
  std::vector<float> bodies = {};  ///< poses of the robot's bodies: position, quaternion (x, y, z, w)
  std::optional<Eigen::Isometry3d> truth = {}, plan = {}, estimate = {};  ///< X_WC; plan: X_PC
  std::optional<files::Matrix6d> covariance = {};     ///< covariance of the estimate, as in slam::Estimate
  std::optional<std::array<FootPlace, 2>> feet = {};  ///< left, right
  std::optional<Eigen::Vector2d> zmp = {};            ///< m on the ground
  std::vector<cv::Point2f> support = {};              ///< corners of the support polygon, in W
  double margin_m = NAN;                              ///< distance of the zmp inside it; NaN if unknown
  std::optional<slam::FrameReport> report = {};
  std::optional<std::vector<slam::MapPoint>> map = {};  ///< absent if unchanged
  std::optional<std::size_t> rig = {};  ///< number with which the page requests the rig's readings
};

/// Estimate minus truth: x, y, z (m, axes of W), heading (rad); standard deviations; NEES. NaN if unknown.
struct FrameError {
  Eigen::Vector4d error = Eigen::Vector4d::Constant(NAN), sigma = error;
  score::PoseNees nees{NAN, NAN};
};
/// Returns the error, or nullopt without truth or estimate.
std::optional<FrameError> error_of(const Frame& frame);
/// Returns the half axes (longer first) and the angle (rad) of a covariance's 3-sigma ellipse.
Eigen::Vector3d ellipse(const Eigen::Matrix2d& covariance);

}  // namespace sim::pages
