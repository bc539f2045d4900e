// A recording in memory, one run of the filter on it, and the likelihood that rates that run. Also trials as
// tasks for other processes, and their records.
#pragma once

#include <memory>

#include "sim/result/job_log.h"
#include "sim/result/result.h"
#include "sim/score/metrics.h"

namespace sim::trials {

using result::JobLog, result::JobRecord;

/// A recording, read once for several trials.
struct Recording {
  scenario::Ended walk;  ///< how the walk ended
  std::string hash;      ///< hash of the recording's files
  recording::RecordingSetup setup;
  std::vector<slam::Observation> observations;  ///< in the order of arrival
  recording::Truth truth;                       ///< for the score only
};

/// Reads a result folder's recording and decodes its images. Throws FileError as replay does.
Recording load(const fs::path& result_folder);

/// Returns −ln N(error; 0, covariance) of a pose (see score::pose_nees), or nothing if the covariance is not
/// positive definite.
std::optional<double> pose_nll(const Eigen::Isometry3d& X_WC_true, const Eigen::Isometry3d& X_WC_estimate,
                               const score::Matrix6d& covariance);

/// Returns the negative log likelihood of the innovations, −ln N(ν; 0, S) for each sensor in each frame,
/// which does not need the truth. It is the sum over the sensors of their means per degree of freedom, so
/// that settings with different numbers of measurements can be compared. Returns nothing without innovations
/// or if an innovation covariance is not positive definite. Readings beyond their gates count too. A landmark
/// that was searched for without an accepted match counts as if its pixel were uniformly distributed
/// over an image of area_px2.
std::optional<double> innovation_nll(const tracking::Tracked& tracked, double area_px2);

/// Applies the sensor errors of `scenario` and runs its filter if it has a slam section. Returns the record,
/// which keeps a reference to the scenario.
result::RunRecord replay(const Recording& recording, const scenario::ReadScenario& scenario,
                         const estimators::Session& session = {});

/// Returns the score of replay(): ending, cause and metrics, the same as in a result folder bit for bit;
/// lasted_fraction, the fraction of the recording until the filter failed; and, unless the filter failed or a
/// covariance is not positive definite, innovation_nll and pose_nll, the mean over scored frames of −ln
/// N(pose error; 0, P) with 6 degrees of freedom.
JobRecord run_trial(const Recording& recording, const scenario::ReadScenario& scenario,
                    const std::string& key = "", const estimators::Session& session = {});

/// A trial for another process.
struct Task {
  std::string key;  ///< in the log
  std::uint64_t seed = 0;
  std::string scenario;  ///< the whole scenario as YAML, with its seed
  fs::path recording{};  ///< a result folder; empty: the recording is in the cache
};

/// Runs tasks and adds their records to the log.
using RunTasks = std::function<void(const std::vector<Task>&, JobLog&)>;

/// Returns the recording for a scenario. session: "session-1" for one before the task's own, otherwise empty.
using RecordingOf = std::function<std::shared_ptr<const Recording>(const scenario::ReadScenario&,
                                                                   const std::string& session)>;

/// Runs the trial (without a filter only its walk) and returns its record, "not started" if the trial is at
/// fault. Throws FileError if the machine is at fault.
JobRecord run_task(const Task& task, const RecordingOf& recording_of);

}  // namespace sim::trials
