// The self check of a run: a run is not scored if its ideal sensors disagree with its truth.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sim/live/frame_pipeline.h"
#include "sim/recording/recording.h"
#include "sim/score/surfaces.h"
#include "slam/camera.h"
#include "slam/observation.h"

namespace sim::live {

/// Integration by the trapezoidal rule: turns composed, the specific force turned by the mean of the
/// attitudes at both ends of its reading, the position along the mean of both velocities. Not the inverse of
/// the formula of the readings, which does not use positions. A new integration starts at the truth every 10
/// s and lasts 30 s; all restart after a reading of more than 50 m/s², as in a violent push or a fall,
/// because a mean does not show how a blow is distributed.
class InertialCheck {
 public:
  explicit InertialCheck(const recording::TrueMotion& start);

  /// The next reading of both, and the true motion at its end.
  void add(const slam::InertialSample& gyro, const slam::InertialSample& accelerometer,
           const recording::TrueMotion& end);

  double worst_position_m() const { return worst_position_m_; }
  double worst_yaw_rad() const { return worst_yaw_rad_; }
  /// Duration of the longest integration.
  slam::Stamp longest() const { return longest_; }

 private:
  void compare(const recording::TrueMotion& integrated, const recording::TrueMotion& truth);

  std::deque<recording::TrueMotion> integrations_;  // t: start of each
  slam::Stamp longest_{0};
  double worst_position_m_ = 0, worst_yaw_rad_ = 0;
};

/// Uses the filter's camera model, which shares nothing with the renderer's lens. One pair of images a
/// second, 0.4 s apart: half a step, when the head sways the other way, so that an image that lags
/// shows.
class ViewCheck {
 public:
  ViewCheck(const slam::CameraIntrinsics& intrinsics, std::vector<score::Surface> surfaces);

  /// An image and the true pose at its stamp.
  void add(const cv::Mat& image, slam::Stamp t, const Eigen::Isometry3d& X_WC);

  std::size_t points() const { return points_; }
  /// Median distance (px) of found points from their projections; nullopt for fewer than
  /// 30 points, as when the lights are off.
  std::optional<double> median_px() const;

 private:
  struct Corner {
    cv::Point pixel;
    Eigen::Vector3d p_W;
  };
  void extract_corners(const cv::Mat& image, slam::Stamp t, const Eigen::Isometry3d& X_WC);
  void find_corners(const cv::Mat& image, const Eigen::Isometry3d& X_WC);
  std::optional<Eigen::Vector2d> expected(const Eigen::Vector3d& p_W, const Eigen::Isometry3d& X_WC) const;

  slam::Camera camera_;
  std::vector<score::Surface> surfaces_;
  std::optional<slam::Stamp> first_t_;
  cv::Mat first_;
  std::vector<Corner> corners_;
  std::size_t points_ = 0;
  std::array<std::size_t, 200> distances_{};  // how many, by twentieths of a pixel
};

/// Largest errors of the ideal sensors of a run.
inline constexpr double kInertialPosition_m = 0.01, kInertialYaw_deg = 0.01, kView_px = 0.3;

/// Given the readings of the ideal sensors and their true poses.
struct SelfCheck {
  InertialCheck inertial;
  std::optional<ViewCheck> view;  ///< absent without a camera

  /// Describes the disagreements; empty if all agree.
  std::string complaint() const;
  /// The figures, for the recording's self_check.json.
  std::string json() const;
};

/// Writes readings of ideal sensors and ground truth.
class CheckedRecording {
 public:
  /// start: true motion at t = 0. surfaces: of the room; if empty, images are not checked.
  CheckedRecording(const std::filesystem::path& folder, const recording::RecordingSetup& setup,
                   const recording::TrueMotion& start, const std::vector<score::Surface>& surfaces);

  void add(const recording::BodyReading& reading) { writer_.add(reading); }
  void add(const recording::TruePoses& poses) { writer_.add(poses); }
  void add(const recording::TrueFeet& feet) { writer_.add(feet); }
  void add(const std::vector<score::StepCorrection>& steps) { writer_.add(steps); }
  void add(const Frame& frame);
  /// A reading of the chest IMU, which the frame it belongs to records, and the true motion at its end.
  void add(const slam::InertialSample& gyro, const slam::InertialSample& accelerometer,
           const recording::TrueMotion& end);

  /// Writes the figures of the self check and closes the recording. Describes the disagreements with the
  /// truth; empty if all agree.
  std::string finish();

 private:
  recording::RecordingWriter writer_;
  SelfCheck check_;
};

}  // namespace sim::live
