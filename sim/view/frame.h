// One frame as the page shows it: what the camera saw, what the filter made of it, and where everything was.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sim/files/trajectory_file.h"
#include "slam/frame_report.h"
#include "slam/observation.h"

namespace sim::view {

/// A foot on the ground: (x m, y m, yaw rad) of its sole point, true and planned.
struct FootPlace {
  Eigen::Vector3d truth = Eigen::Vector3d::Zero(), plan = Eigen::Vector3d::Zero();
  bool planned_down = true;
  double load_n = 0;  ///< vertical force
};

/// What is not known is absent or empty.
struct Frame {
  slam::Stamp t{0};
  cv::Mat image = {};              ///< 8-bit grey
  std::vector<float> bodies = {};  ///< of the robot: position, quaternion (x, y, z, w) each
  std::optional<Eigen::Isometry3d> truth = {}, plan = {}, estimate = {};  ///< X_WC; plan: X_PC
  std::optional<files::Matrix6d> covariance = {};             ///< of the estimate, as slam::Estimate has it
  std::optional<std::array<FootPlace, 2>> feet = {};          ///< left, right
  std::optional<Eigen::Vector2d> zmp = {}, planned_zmp = {};  ///< m on the ground; planned_zmp in P
  std::optional<slam::FrameReport> report = {};
  std::optional<std::vector<slam::MapPoint>> map = {};  ///< absent where it is the one before
};

/// A force on a foot: position of its sole point (m, W), its yaw, force and torque in its axes.
struct SoleForce {
  Eigen::Vector3d place;  ///< x, y (m), yaw (rad)
  Eigen::Vector3d force, torque;
};

/// The zero-moment point of the forces of the ground on both soles, which are taken as level; nothing while
/// they carry less than 20 N.
std::optional<Eigen::Vector2d> zero_moment_point(const std::array<SoleForce, 2>& soles);

/// What the filter's state is, in a sentence.
std::string state_in_words(const slam::FrameReport& report);

/// As an object of the page's script (web/run.js says what each key is). Lengths in m, angles in rad; what is
/// not finite is null.
std::string to_json(const Frame& frame);

/// A WebSocket message: the length of the JSON (little-endian, four bytes), the JSON, the grey image row by
/// row.
std::string to_message(const Frame& frame);

}  // namespace sim::view
