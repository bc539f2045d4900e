// An estimator's answer to an observation, and the error of an estimator that failed.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "slam/frame_report.h"
#include "slam/observation.h"
#include "slam/state.h"

namespace sim::estimators {

/// The estimated pose of the camera. covariance: as slam::Estimate defines it; absent if the estimator gives
/// none.
struct PoseEstimate {
  slam::Stamp t{0};
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  std::optional<slam::Matrix6d> covariance;
};

/// An estimator's answer to an observation.
struct Answer {
  PoseEstimate estimate;
  slam::FrameReport report;  ///< of an external estimator: stamp, health, cause and number of landmarks
  std::optional<std::vector<slam::MapPoint>> map = std::nullopt;  ///< the whole map, if the answer has one
  double external_cpu_ms = 0;  ///< CPU time that the answer took in another process
};

/// The estimator crashed, missed a time limit or gave an invalid answer. what(): the cause.
class EstimatorFailed : public std::runtime_error {
 public:
  explicit EstimatorFailed(const std::string& cause, std::string its_log = "")
      : std::runtime_error(cause), log(std::move(its_log)) {}

  std::string log;  ///< what it wrote to its standard error
};

/// Throws EstimatorFailed if a number is not finite, the pose is invalid or its stamp is outside
/// [earliest, newest].
void require_valid(const Answer& answer, slam::Stamp earliest, slam::Stamp newest);

/// Returns external text as one line of printable ASCII characters.
std::string printable(std::string_view text);

}  // namespace sim::estimators
