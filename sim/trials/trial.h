// A recording in memory, one run of the filter on it, and the terms that rate that run.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/recording/recording.h"
#include "sim/scenario/ending.h"
#include "sim/scenario/scenario.h"
#include "sim/score/metrics.h"
#include "sim/score/score_context.h"
#include "sim/tracking/tracking.h"

namespace sim::trials {

/// A recording that is read once and that several threads may use at the same time.
struct Recording {
  std::string name;      ///< "tangent_circle/seed-1"
  scenario::Ended walk;  ///< how the walk ended
  std::string hash;      ///< of the recording's files
  recording::RecordingSetup setup;
  /// In the order of arrival; images are views of `pictures`, which share no counter among threads.
  std::vector<slam::Observation> observations;
  std::vector<cv::Mat> pictures;
  /// The sensor errors in the observations, see errors_of; empty if the sensors are ideal.
  std::string errors;
  recording::Truth truth;  ///< for the score only
};

/// Reads a result folder's recording, images decoded. Throws FileError and ConfigError as replay does.
Recording load(const std::filesystem::path& result_folder);

/// Reads the recording and applies the sensor errors of `scenario` (errors.*, seed) for all trials that share
/// them.
Recording load(const std::filesystem::path& result_folder, const scenario::Scenario& scenario);

/// Reads only the name and the hash of the recording.
Recording load_identity(const std::filesystem::path& result_folder);

/// The keys errors.* and the seed, which determine the sensor errors, as text.
std::string errors_of(const scenario::Scenario& scenario);

/// Losses of one run of the filter.
struct Terms {
  double pose_nll = 0;        ///< mean over scored frames of −ln N(pose error; 0, P), 6 degrees of freedom
  double innovation_nll = 0;  ///< mean over frames of −ln N(innovations; 0, S); needs no truth
  double rmse_m = 0;          ///< of the position, not aligned
};

/// −ln N(error; 0, covariance) of a pose, see score::pose_nees. Returns nullopt unless the covariance is
/// positive definite.
std::optional<double> pose_nll(const Eigen::Isometry3d& X_WC_true, const Eigen::Isometry3d& X_WC_estimate,
                               const score::Matrix6d& covariance);

/// −ln N(innovation; 0, S).
double nll(const slam::Nis& nis);

/// The sum over one frame: internal measurements, also rejected ones, and accepted matches with the noise
/// that the update expects. A landmark that was not found may be anywhere in the image: ln(its pixels).
double innovation_nll(const slam::FrameReport& report, double image_px2);

/// The terms of a run. Returns nullopt if the filter failed, a covariance is not positive definite or rmse_m
/// has no value.
std::optional<Terms> terms(const score::ScoreContext& scored, const tracking::Tracked& tracked,
                           const score::Metrics& metrics, const slam::CameraIntrinsics& camera);

/// One run of the filter.
struct Trial {
  scenario::Ended ended;       ///< as in a result folder
  score::Metrics metrics;      ///< as a result folder's, bit for bit
  std::optional<Terms> terms;  ///< absent if the filter failed
  double lasted_fraction = 1;  ///< fraction of the recording until the filter failed
};

/// Applies the sensor errors of `scenario` unless the recording contains them, runs its filter and scores it.
/// The scenario must have a slam section. Throws std::logic_error if the recording contains other errors.
Trial run_trial(const Recording& recording, const scenario::ReadScenario& scenario);

}  // namespace sim::trials
