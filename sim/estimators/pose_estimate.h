// What an estimator answers to an observation, and how one that is no answer is reported.
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

/// The estimated pose of the camera. covariance: as slam::Estimate defines it; absent where the estimator
/// states none.
struct PoseEstimate {
  slam::Stamp t{0};
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  std::optional<slam::Matrix6d> covariance;
};

/// An estimator's answer to an observation.
struct Answer {
  PoseEstimate estimate;
  slam::Health health = slam::Health::ok;
  std::string cause;                ///< why the health is not ok
  std::vector<slam::MapPoint> map;  ///< the whole of it, or empty where it is not told this time
  double outside_cpu_ms = 0;        ///< CPU time that the answer took in another process
};

/// The estimator crashed, did not answer in time, or gave an answer that is none. what(): the cause.
class EstimatorFailed : public std::runtime_error {
 public:
  explicit EstimatorFailed(const std::string& cause, std::string its_log = "")
      : std::runtime_error(cause), log(std::move(its_log)) {}

  std::string log;  ///< what it wrote to its standard error
};

/// Throws EstimatorFailed where a number of the answer is not finite, the pose is none, or its stamp is not
/// within [earliest, newest]: the stamps of the answer before, and of the newest observation.
void require_sound(const Answer& answer, slam::Stamp earliest, slam::Stamp newest);

/// Text of others on one line of printable ASCII characters.
std::string printable(std::string_view text);

}  // namespace sim::estimators
