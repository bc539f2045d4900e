// A result folder as read by pages and the view, with errors and normalized errors computed by sim/score; and
// a frame of it as they show it: the image, the filter's matches, and the poses.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/files/trajectory_file.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording.h"
#include "sim/result/score_file.h"
#include "sim/score/trajectory.h"
#include "slam/frame_report.h"
#include "slam/observation.h"

namespace sim::pages {

namespace fs = std::filesystem;

/// A foot on the ground.
struct FootPlace : recording::TrueFoot {
  std::optional<Eigen::Vector3d> landed{};  ///< where it last landed; absent while in the air
};

/// Unknown parts are absent or empty.
struct Frame {
  slam::Stamp t{0};
  cv::Mat image = {};              ///< 8-bit gray
  std::vector<float> bodies = {};  ///< poses of the robot's bodies: position, quaternion (x, y, z, w)
  std::optional<Eigen::Isometry3d> truth = {}, plan = {}, estimate = {};  ///< X_WC; plan: X_PC
  std::optional<files::Matrix6d> covariance = {};     ///< of the estimate, as in slam::Estimate
  std::optional<std::array<FootPlace, 2>> feet = {};  ///< left, right
  std::optional<Eigen::Vector2d> zmp = {};            ///< m on the ground
  std::vector<cv::Point2f> support = {};              ///< corners of the support polygon, in W
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

/// Returns a frame as JSON for sim/view/web/run.js, which documents the keys. m, rad; null if not finite.
nlohmann::ordered_json to_json(const Frame& frame);

/// Returns the length of a JSON text (little-endian, four bytes) and the text, padded with blanks to a
/// multiple of four bytes.
std::string with_length(std::string json);
/// Returns a WebSocket message: with_length() of the JSON, then the gray image row by row.
std::string to_message(const Frame& frame);

/// Returns a rig reading for sim/view/web/sensors.js. Depth: width and height (uint32), then mm row by row
/// (uint16; 0: none). Other cameras: a PNG. Lidar: points in the head camera's frame, x, y, z (m) and
/// intensity as float32. IMU: nothing.
std::string sent(const slam::RigReading& reading, const rig::RigSensor& sensor);
/// Returns 256 colors from blue through green to red (turbo).
const cv::Mat3b& palette();

/// Returns the image file of each frame, or an empty path; for a rig camera or lidar, the file of the newest
/// reading. Throws FileError if a file is outside the recording.
std::vector<fs::path> image_files(const std::vector<Frame>& frames, const fs::path& recording,
                                  const std::string& sensor = "cam0");

/// The pictures of a recording, which may be untrusted: a browser gets them only as they were recorded.
class Pictures {
 public:
  /// Throws FileError if the recording is unfinished or was edited.
  explicit Pictures(const fs::path& recording);
  /// Returns the reading of a rig sensor or the head camera from a file. Throws FileError unless the file has
  /// the hash in the manifest and an image has the camera's size.
  slam::RigReading read(const rig::RigSensor& sensor, const fs::path& file) const;
  const recording::RecordingSetup& setup() const { return setup_; }

 private:
  fs::path folder_;
  recording::Manifest manifest_;
  recording::RecordingSetup setup_;
};

/// Factors from SI to the units of the pages.
inline constexpr double kMm = 1e3, kDeg = 180 / std::numbers::pi;

using Column = std::vector<double>;

/// A comma-separated file, accessed by column name; extra columns are ignored. Units are removed from the
/// names ("p_W_x [m]" becomes p_W_x), and so is a '#' at the start of the first one.
class Table {
 public:
  /// Throws FileError if the file cannot be read, or if it has duplicate columns or a row of another length.
  explicit Table(const fs::path& file);

  std::size_t rows() const { return rows_; }
  bool has(std::string_view column) const { return columns_.contains(column); }
  /// Returns a column as text. Throws FileError if the column is missing.
  const std::vector<std::string>& text(std::string_view column) const;
  /// Returns a column as numbers; NaN if a field is not a number.
  Column numbers(std::string_view column) const;
  /// Returns a column of nanoseconds, converted to seconds.
  Column seconds(std::string_view column) const;
  /// Returns a column of time stamps. Throws FileError if a field is not one.
  std::vector<slam::Stamp> stamps(std::string_view column) const;

 private:
  fs::path file_;
  std::size_t rows_ = 0;
  std::map<std::string, std::vector<std::string>, std::less<>> columns_;
};

/// A trajectory as columns: time (s) and position (m); NaN if missing.
struct Path {
  Column t, x, y, z;
};

/// Errors of the frames (FrameError) as columns, in SI units; NaN if missing.
struct Errors {
  Column t;
  std::array<Column, 4> error, sigma;  ///< x, y, z, yaw
  Column distance;
  Column nees_position, nees_orientation;
};

/// A result folder. Parts that the run did not write (no filter, no camera) are absent.
struct RunData : result::SeedScore {
  std::string alignment = "none";  ///< how the estimate was aligned with the truth before it was scored
  fs::path folder;
  fs::path recording;                           ///< the result's own recording if finished, else empty
  std::optional<recording::Truth> recorded;     ///< the truth in that recording
  std::map<std::string, std::string> settings;  ///< settings_of()
  result::About about;
  std::optional<double> frame_cpu_ms_mean, frame_cpu_ms_median, frame_cpu_ms_p99;  ///< batch: mean
  Path truth, plan, waist_truth, waist_plan;
  bool truth_aligned = false;  ///< positions only: drawn after SE(3) alignment with the estimate
  std::optional<Path> estimate;
  std::optional<Path> waist_estimate;  ///< only for a steered walk, like waist_desired and corrected_steps
  std::optional<Path> waist_desired;
  std::optional<Errors> errors;
  std::optional<Path> odometry;  ///< from the same sensors without images
  Column odometry_error;         ///< its distance from the truth, m
  std::optional<Table> filter_frames, feet, frame_times, corrected_steps, answers;
  std::vector<Frame> frames;  ///< truth, plan, estimate, report and map, without images

  /// Returns the value of a key in one line, or "" if it is unknown.
  std::string setting(const std::string& key) const;
  /// Returns "tangent_circle, seed 1", with the estimator unless it is the filter, and with its alignment.
  std::string label() const;
};

/// Returns all keys of a result's scenario except the seed, plus "revision" and "program" (the hash of an
/// external estimator's files). Contains no scenario keys if the scenario is missing or from another version.
std::map<std::string, std::string> settings_of(const fs::path& result, const result::About& about);

/// Returns a key's value without YAML's indentation and line breaks.
std::string in_one_line(const std::string& value);

/// Returns the keys (including "estimator") that differ between runs of a scenario, with each run's value or
/// "".
std::map<std::string, std::vector<std::string>> changed_keys(const std::vector<const RunData*>& runs);

/// Returns what distinguishes each run from the others of its scenario, ignoring seeds: the keys that differ,
/// such as "slam.vision.sigma_px=3", preceded by the estimator if it differs or if no key does.
std::vector<std::string> variants(const std::vector<const RunData*>& runs);
/// Returns the same without estimator, controller and robot; "" if no other key differs.
std::vector<std::string> other_settings(const std::vector<const RunData*>& runs);

/// Returns how a result's estimate was aligned with the truth before it was scored, or "none".
std::string alignment_of(const result::About& about);
/// Returns a metric's column in tables over several results: "rmse_m_after_sim3" if alignment affects it.
std::string column_of(const std::string& metric, const std::string& alignment);

/// Reads a result. Throws FileError if it is not a result, if a file is missing or broken, or if its
/// recording was edited.
RunData read_run(const fs::path& result_folder);

}  // namespace sim::pages
