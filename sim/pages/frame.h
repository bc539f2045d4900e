// One frame as pages and the view show it: the image, the matches of the filter, and the poses.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sim/files/trajectory_file.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording.h"
#include "sim/score/consistency.h"
#include "slam/frame_report.h"
#include "slam/observation.h"

namespace sim::pages {

namespace fs = std::filesystem;

/// A foot on the ground.
struct FootPlace : recording::TrueFoot {
  std::optional<Eigen::Vector3d> landed{};  ///< place of its last landing; absent in the air
};

/// Unknown parts are absent or empty.
struct Frame {
  slam::Stamp t{0};
  cv::Mat image = {};              ///< 8-bit grey
  std::vector<float> bodies = {};  ///< of the robot: position, quaternion (x, y, z, w) each
  std::optional<Eigen::Isometry3d> truth = {}, plan = {}, estimate = {};  ///< X_WC; plan: X_PC
  std::optional<files::Matrix6d> covariance = {};     ///< of the estimate, as in slam::Estimate
  std::optional<std::array<FootPlace, 2>> feet = {};  ///< left, right
  std::optional<Eigen::Vector2d> zmp = {};            ///< m on the ground
  std::vector<cv::Point2f> support = {};              ///< corners of the support polygon, in W
  std::optional<slam::FrameReport> report = {};
  std::optional<std::vector<slam::MapPoint>> map = {};  ///< absent if it is the one before
  std::optional<std::size_t> rig = {};  ///< number by which the page asks for the rig's readings
};

/// Estimate minus truth: x, y, z (m, axes of W), heading (rad); standard deviations; NEES. NaN if unknown.
struct FrameError {
  Eigen::Vector4d error = Eigen::Vector4d::Constant(NAN), sigma = error;
  score::PoseNees nees{NAN, NAN};
};
/// Empty without truth or estimate.
std::optional<FrameError> error_of(const Frame& frame);
/// Half axes (longer first) and angle (rad) of the 3-sigma ellipse of a covariance.
Eigen::Vector3d ellipse(const Eigen::Matrix2d& covariance);

/// JSON of a frame for the page's script (web/run.js documents the keys). m, rad; null if not finite.
nlohmann::ordered_json to_json(const Frame& frame);

/// A WebSocket message: the length of the JSON (little-endian, four bytes), the JSON, the grey image by rows.
std::string to_message(const Frame& frame);

/// Returns a reading of the rig as a page shows it: of a camera a PNG, with depth in the color map turbo from
/// nearest_m (blue) to furthest_m (red) and black where there is none; of a lidar its points in the frame of
/// the head camera, x, y, z in m as float32; of an IMU nothing.
std::string shown(const slam::RigReading& reading, const rig::RigSensor& sensor);
/// Describes the output of shown() in words.
std::string words_of(const rig::RigSensor& sensor);

/// The image file of each frame, or an empty path. For a camera or a lidar of the rig: the file of the
/// newest reading. Throws FileError if a file is outside of the recording.
std::vector<fs::path> image_files(const std::vector<Frame>& frames, const fs::path& recording,
                                  const std::string& sensor = "cam0");

/// The pictures of a recording, which may be a stranger's: a browser gets them only as they were recorded.
class Pictures {
 public:
  /// Throws FileError if the recording is unfinished or was edited.
  explicit Pictures(const fs::path& recording);
  /// The bytes of an image file. Throws FileError unless it is a PNG of the camera's size and listed hash.
  std::string png(const fs::path& file) const;
  /// shown() of the file of a reading of the rig. Throws FileError as RecordingReader.
  std::string rig(const rig::RigSensor& sensor, const fs::path& file) const;
  const recording::RecordingSetup& setup() const { return setup_; }

 private:
  fs::path folder_;
  recording::Manifest manifest_;
  recording::RecordingSetup setup_;
};

}  // namespace sim::pages
