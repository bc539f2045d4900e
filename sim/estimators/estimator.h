// The interface of every estimator: the filter, the other built-in ones and external programs.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>

#include "sim/programs/child_program.h"
#include "sim/programs/choice.h"
#include "sim/rig/rig.h"
#include "slam/frame_report.h"
#include "slam/observation.h"
#include "slam/options.h"
#include "slam/saved_map.h"
#include "slam/state.h"

namespace sim::estimators {

/// The estimated pose of the camera. covariance: as defined by slam::Estimate; absent if the estimator gives
/// none.
struct PoseEstimate {
  slam::Stamp t{0};
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  std::optional<slam::Matrix6d> covariance;
};

/// An estimator's answer to an observation.
struct Answer {
  std::optional<PoseEstimate> estimate;  ///< absent if the estimator is not ready, or lost without a pose
  slam::FrameReport report;  ///< for an external estimator, only stamp, health, cause and number of landmarks
  std::optional<std::vector<slam::MapPoint>> map = std::nullopt;  ///< the whole map, if the answer has one
  double external_cpu_ms = 0;  ///< CPU time of the answer in another process
};

/// The estimator crashed, missed a time limit or gave an invalid answer. what(): the cause.
using EstimatorFailed = programs::ProgramFailed;

/// Throws EstimatorFailed if a number is not finite or the pose is invalid. The pose's stamp must be
/// `observed`, the observation's own, or lie between the last pose's stamp and the newest observation's.
void require_valid(const Answer& answer, slam::Stamp observed, slam::Stamp last, slam::Stamp newest);

/// A session of a robot in the same place, with the map and the files of the previous sessions.
struct Session {
  std::optional<slam::SavedMap> map = {};  ///< for the filter
  std::filesystem::path map_file = {};     ///< the same in a file; empty: none
  int index = 1, count = 1;
  /// The absolute path of a folder in which an external program finds the files that it left in the session
  /// before; empty: none.
  std::filesystem::path memory = {};
};

/// Input of an estimator before the first observation.
struct Start {
  slam::Calibration calibration;
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();  ///< the planned camera pose at t = 0
  std::uint64_t seed = 1;                                  ///< the run's seed
  slam::Options options = {};                              ///< the filter's options
  double camera_rate_hz = 30, camera_readout_s = 0;
  rig::RigSensor chest_imu = {
      .name = "imu0", .kind = rig::Kind::imu, .rate_hz = 200};  ///< at calibration.X_CG
  std::vector<rig::RigSensor> rig = {};                         ///< additional sensors of the observations
  std::vector<std::string> joints = {};  ///< joints with encoders; empty: no encoders or force sensors
  double body_rate_hz = 200;             ///< rate of encoders and force sensors
  Session session = {};
};

/// A running estimator. Exceptions from it are failures of the estimator.
class Estimator {
 public:
  virtual ~Estimator() = default;
  /// Answers an observation; called in the order of arrival.
  virtual Answer step(const slam::Observation& observation) = 0;
  /// Returns whether it uses the readings of a sensor of the rig (RigReading::sensor).
  virtual bool uses(int) const { return true; }
  /// Returns the current map.
  virtual std::vector<slam::MapPoint> map() const = 0;
  /// Returns the map for a later session, if the estimator makes one.
  virtual std::optional<slam::SavedMap> saved_map() const { return std::nullopt; }
  /// Returns the poses of all answers, each estimated from all observations; empty if the estimator does
  /// not smooth. Call this once, after the last answer.
  virtual std::vector<PoseEstimate> smoothed() { return {}; }
  /// Ends the estimator and returns its output on standard error. Throws EstimatorFailed if it has sent
  /// more answers than it was asked for.
  virtual std::string finish() { return {}; }
};

using Step = std::function<Answer(const slam::Observation&)>;

/// Returns an estimator that calls a function. Its answers are checked (require_valid()); its map is the
/// latest one in an answer.
std::unique_ptr<Estimator> estimator_from(Step step);

/// Names of the built-in estimators, which are values of the scenario's key `estimator`. New ones are added
/// in estimators.cc.
std::span<const std::string_view> estimator_names();

/// Creates the chosen estimator. Throws std::invalid_argument if its program cannot be started or does not
/// accept the start, EstimatorFailed if it crashes or misses its time limit.
std::unique_ptr<Estimator> make_estimator(const programs::Choice& choice, const Start& start);

}  // namespace sim::estimators
