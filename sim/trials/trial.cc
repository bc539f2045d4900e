#include "sim/trials/trial.h"

#include <Eigen/Cholesky>

#include "sim/result/score_file.h"

namespace sim::trials {
namespace {

// Returns the fraction of the recording until the filter diverged or the estimator failed.
double lasted_fraction(const Recording& recording, const tracking::Tracked& tracked) {
  const double end_s = slam::seconds(recording.observations.back().t);
  if (tracked.failed)
    return tracked.frames.empty() || end_s <= 0 ? 0 : slam::seconds(tracked.frames.back().report.t) / end_s;
  if (!tracked.failure()) return 1;
  const auto losses = tracked.losses();
  return end_s > 0 ? slam::seconds(losses.back().from) / end_s : 0;
}

// Returns nullopt if the filter failed or a covariance is not positive definite.
std::optional<double> mean_pose_nll(const score::ScoreContext& scored) {
  if (scored.no_estimate || scored.pairs.empty()) return std::nullopt;
  double sum = 0;
  auto pose = scored.run.estimate->begin();
  for (const score::PosePair& pair : scored.pairs) {
    while (pose->t != pair.t) ++pose;
    if (!pose->covariance) return std::nullopt;
    const auto nll = pose_nll(pair.X_true, pair.X_estimate, *pose->covariance);
    if (!nll) return std::nullopt;
    sum += *nll;
  }
  return std::isfinite(sum) ? std::optional(sum / double(scored.pairs.size())) : std::nullopt;
}

}  // namespace

Recording load(const fs::path& folder) {
  Recording recording;
  recording.walk = *result::read_about_of_walk(folder / "about.json").walk;
  recording::RecordingReader reader(folder / "recording");
  recording.setup = reader.setup();
  recording.hash = reader.hash();
  while (auto ideal = reader.next()) recording.observations.push_back(std::move(*ideal));
  recording.truth = recording::read_truth(folder / "recording");
  return recording;
}

std::optional<double> pose_nll(const Eigen::Isometry3d& X_WC_true, const Eigen::Isometry3d& X_WC_estimate,
                               const score::Matrix6d& covariance) {
  const Eigen::LLT<score::Matrix6d> llt(covariance);
  if (llt.info() != Eigen::Success || !covariance.allFinite()) return std::nullopt;
  Eigen::Matrix<double, 6, 1> error;
  error << score::rotation_vector(X_WC_estimate.linear().transpose() * X_WC_true.linear()),
      X_WC_true.translation() - X_WC_estimate.translation();
  const double log_determinant = 2 * llt.matrixLLT().diagonal().array().log().sum();
  return (llt.matrixL().solve(error).squaredNorm() + log_determinant + 6 * std::log(2 * std::numbers::pi)) /
         2;
}

std::optional<double> innovation_nll(const tracking::Tracked& tracked, double area_px2) {
  struct Sum {
    double nll = 0;
    int dof = 0;
  };
  std::map<std::string_view, Sum> sums;
  for (const tracking::TrackedFrame& frame : tracked.frames) {
    int matched_dof = 0;
    for (const auto& [sensor, nis] : frame.report.innovations) {
      Sum& sum = sums[sensor];
      sum.nll += (nis.value + nis.log_determinant + nis.dof * std::log(2 * std::numbers::pi)) / 2;
      sum.dof += nis.dof;
      if (sensor == "vision") matched_dof = nis.dof;
    }
    const int unmatched = int(frame.report.searched.size()) - matched_dof / 2;
    if (unmatched > 0)
      sums["vision"].nll += unmatched * std::log(area_px2), sums["vision"].dof += 2 * unmatched;
  }
  double total = 0;
  for (const auto& [sensor, sum] : sums) total += sum.nll / sum.dof;
  return sums.empty() || !std::isfinite(total) ? std::nullopt : std::optional(total);
}

result::RunRecord replay(const Recording& recording, const scenario::ReadScenario& scenario,
                         const estimators::Session& session) {
  const recording::RecordingSetup& setup = recording.setup;
  result::RunRecord run{scenario, {recording.walk.ending}, setup, recording.truth, {}, recording.hash};
  if (!scenario.scenario.slam) return run;
  tracking::Tracking tracking(scenario.scenario, setup.calibration, setup.X_WC_start, setup.camera_rate_hz,
                              setup.rig, setup.joints, session);
  for (const slam::Observation& observation : recording.observations) tracking.process(observation);
  run.tracked = tracking.finish();
  return run;
}

JobRecord run_trial(const Recording& recording, const scenario::ReadScenario& scenario,
                    const std::string& key, const estimators::Session& session) {
  const result::RunRecord run = replay(recording, scenario, session);
  const score::Run input = result::score_input(run);
  const score::ScoreContext scored(input);
  const scenario::Ended ended = result::ending_of(run);
  JobRecord record{key,
                   scenario.scenario.seed,
                   std::string(name_of(ended.ending)),
                   ended.ending == recording.walk.ending ? recording.walk.cause : ended.cause,
                   {}};
  for (const auto& [name, metric] : score::evaluate(scored))
    if (metric.value) record.values[name] = *metric.value;
  if (!run.tracked) return record;
  record.values["lasted_fraction"] = lasted_fraction(recording, *run.tracked);
  if (const auto nll = mean_pose_nll(scored)) record.values["pose_nll"] = *nll;
  const slam::CameraIntrinsics& camera = recording.setup.calibration.camera;
  const auto nll = innovation_nll(*run.tracked, camera.width_px * camera.height_px);
  if (nll && !scored.no_estimate) record.values["innovation_nll"] = *nll;
  return record;
}

JobRecord run_task(const Task& task, const RecordingOf& recording_of) {
  const scenario::ReadScenario read = scenario::read_scenario_text(task.scenario, "task.yaml");
  try {
    if (!read.scenario.sessions.empty() && (read.scenario.estimator.source == programs::Source::program ||
                                            read.scenario.walk.steering.by == walking::SteeredBy::estimate))
      throw std::invalid_argument(
          "sessions: a trial has no memory for an external program, and no walk that is steered in a map");
    estimators::Session before{.count = int(read.scenario.sessions.size()) + 1};
    for (std::size_t i = 0; i < read.scenario.sessions.size(); ++i) {
      const scenario::ReadScenario session = scenario::session(read, i);
      const auto walked = recording_of(session, fmt::format("session-{}", i + 1));
      if (auto made = replay(*walked, session, before).tracked->saved_map) before.map = std::move(made);
    }
    const auto recording = recording_of(read, "");
    const scenario::Ended& walk = recording->walk;
    if (walk.ending == scenario::Ending::failed)  // there is nothing to replay
      return {task.key, read.scenario.seed, std::string(name_of(walk.ending)), walk.cause, {}};
    return run_trial(*recording, read, task.key, before);
  } catch (const files::FileError&) {
    throw;  // the machine's fault, such as a full disk
  } catch (const std::exception& e) {
    return {task.key, read.scenario.seed, std::string(name_of(scenario::Ending::not_started)), e.what(), {}};
  }
}

}  // namespace sim::trials
