// The self-check of a run. A run whose ideal sensors disagree with its truth is not scored.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <utility>

#include "sim/recording/recording.h"
#include "sim/score/types.h"
#include "slam/camera.h"
#include "slam/observation.h"

namespace sim::live {

/// Integrates gyro and accelerometer twice with the trapezoidal rule (which is not the inverse of the formula
/// of the readings): at each reading, and at every second reading. The difference between the two shows the
/// error due to the step length, which grows with the robot's vibration. An integration of 30 s starts at the
/// truth every 10 s. All of them restart after a reading of more than 50 m/s², because its mean does not show
/// how a blow was distributed.
struct InertialCheck {
  explicit InertialCheck(const recording::TrueMotion& start) : integrations{{start, start}} {}

  /// Adds one reading of each sensor and the true motion at its end.
  void add(const slam::InertialSample& gyro, const slam::InertialSample& accelerometer,
           const recording::TrueMotion& end);

  struct Integration {
    recording::TrueMotion fine, coarse;  ///< t: at the start
  };
  struct Error {
    double worst = 0, by_step = 0;
  };
  std::deque<Integration> integrations;
  std::optional<std::pair<Eigen::Vector3d, Eigen::Vector3d>> half;  ///< first readings of a pair
  slam::Stamp longest{0};                                           ///< duration of the longest integration
  Error position_m, yaw_deg;
};

/// Once a second, finds the corners of an image again 0.4 s later: after half a step the head sways the other
/// way, which reveals images that lag. Uses the filter's camera model, which shares nothing with the
/// renderer's lens.
class ViewCheck {
 public:
  ViewCheck(const slam::CameraIntrinsics& intrinsics, std::vector<score::Surface> surfaces);
  /// An image and the true pose at its stamp.
  void add(const cv::Mat& image, slam::Stamp t, const Eigen::Isometry3d& X_WC);

  std::size_t points() const { return judged().points; }
  /// Returns the median distance (px) of found points from their projections, or nothing for fewer than 30
  /// points, such as with the lights off.
  std::optional<double> median_px() const { return judged().median_px(); }

 private:
  struct Distances {
    std::array<std::size_t, 200> counts{};  // in bins of a twentieth of a pixel
    std::size_t points = 0;
    std::optional<double> median_px() const;
  };
  struct Corner {
    cv::Point pixel;
    Eigen::Vector3d p_W;
  };
  void extract_corners(const cv::Mat& image, const Eigen::Isometry3d& X_WC);
  void find_corners(const cv::Mat& image, const Eigen::Isometry3d& X_WC);
  /// Returns all points, or only the distinct ones if all are too far off: points along edges may be found
  /// anywhere.
  const Distances& judged() const;
  std::optional<Eigen::Vector2d> expected(const Eigen::Vector3d& p_W, const Eigen::Isometry3d& X_WC) const;

  slam::Camera camera_;
  std::vector<score::Surface> surfaces_;
  std::optional<slam::Stamp> first_t_;
  cv::Mat first_;
  std::vector<Corner> corners_;
  Distances all_, distinct_;
};

/// Largest errors of a run's ideal sensors, beyond those due to the step length.
inline constexpr double kInertialPosition_m = 0.01, kInertialYaw_deg = 0.01, kView_px = 0.3;

/// Checks a run; needs the readings of the ideal sensors and their true poses.
struct SelfCheck {
  InertialCheck inertial;
  std::optional<ViewCheck> view;  ///< absent without a camera

  /// Describes the disagreements, if there are any.
  std::optional<std::string> complaint() const;
  /// The figures, for the recording's self_check.json.
  std::string json() const;
};

}  // namespace sim::live
