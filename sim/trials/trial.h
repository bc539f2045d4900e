// A recording in memory, one run of the filter on it, and the likelihood that rates that run; trials as tasks
// for other processes, and their records.
#pragma once

#include <memory>

#include "sim/result/job_log.h"
#include "sim/result/result.h"
#include "sim/score/metrics.h"

namespace sim::trials {

using result::JobLog, result::JobRecord;

/// A recording that is read once for several trials.
struct Recording {
  scenario::Ended walk;  ///< how the walk ended
  std::string hash;      ///< of the recording's files
  recording::RecordingSetup setup;
  std::vector<slam::Observation> observations;  ///< in the order of arrival
  recording::Truth truth;                       ///< for the score only
};

/// Reads a result folder's recording, images decoded. Throws FileError as replay does.
Recording load(const fs::path& result_folder);

/// Returns −ln N(error; 0, covariance) of a pose, see score::pose_nees; nullopt unless the covariance is
/// positive definite.
std::optional<double> pose_nll(const Eigen::Isometry3d& X_WC_true, const Eigen::Isometry3d& X_WC_estimate,
                               const score::Matrix6d& covariance);

/// Returns the negative log likelihood of the innovations, −ln N(ν; 0, S) of each sensor in each frame,
/// without the truth: the sum over the sensors of their means per degree of freedom, so that settings compare
/// whatever the number of their measurements; nullopt without innovations, or if an innovation covariance is
/// not positive definite. Readings beyond their gates count too, and a landmark searched for without an
/// accepted match counts as if its pixel were uniform over an image of area_px2.
std::optional<double> innovation_nll(const tracking::Tracked& tracked, double area_px2);

/// Applies the sensor errors of `scenario`, runs its filter if it has a slam section, and returns the record,
/// which refers to the scenario.
result::RunRecord replay(const Recording& recording, const scenario::ReadScenario& scenario);

/// Returns the score of replay(): ending, cause and metrics of a result folder, bit for bit; pose_nll, the
/// mean over scored frames of −ln N(pose error; 0, P), 6 degrees of freedom, and innovation_nll, unless the
/// filter failed or a covariance is not positive definite; and lasted_fraction, the part of the recording
/// until the filter failed.
JobRecord run_trial(const Recording& recording, const scenario::ReadScenario& scenario,
                    const std::string& key = "");

/// A trial for another process.
struct Task {
  std::string key;  ///< in the log
  std::uint64_t seed = 0;
  std::string scenario;  ///< all of it as YAML, with its seed
  fs::path recording{};  ///< a result folder; empty: the recording is in the cache
};

/// Runs tasks and adds their records to the log.
using RunTasks = std::function<void(const std::vector<Task>&, JobLog&)>;

/// Returns the recording for a scenario.
using RecordingOf = std::function<std::shared_ptr<const Recording>(const scenario::ReadScenario&)>;

/// Runs the trial, without a filter only its walk, and returns its record, "not started" for a fault of the
/// trial. Throws FileError for a fault of the machine.
JobRecord run_task(const Task& task, const RecordingOf& recording_of);

}  // namespace sim::trials
