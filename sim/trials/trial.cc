#include "sim/trials/trial.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/recording/manifest.h"
#include "sim/result/score_file.h"
#include "sim/result/score_input.h"
#include "sim/scenario/keys.h"

namespace sim::trials {
namespace {

namespace fs = std::filesystem;

std::string name_of(const fs::path& result_folder) {
  const fs::path folder = fs::absolute(result_folder / "x").lexically_normal().parent_path();
  return (folder.parent_path().filename() / folder.filename()).string();
}

// Keeps the observation with a view of its image, which has no reference counter for threads to share.
void keep(slam::Observation observation, Recording& recording) {
  if (!observation.image.empty()) {
    recording.pictures.push_back(observation.image);
    const cv::Mat& owner = recording.pictures.back();
    observation.image = cv::Mat(owner.rows, owner.cols, owner.type(), owner.data, owner.step);
  }
  recording.observations.push_back(std::move(observation));
}

Recording load(const fs::path& folder, sensor_errors::SensorErrors* errors) {
  Recording recording;
  recording.name = name_of(folder);
  recording.walk = *result::read_about_of_walk(folder / "about.json").walk;
  recording::RecordingReader reader(folder / "recording");
  recording.setup = reader.setup();
  recording.hash = reader.hash();
  while (auto ideal = reader.next()) {
    if (!errors)
      keep(std::move(*ideal), recording);
    else
      for (slam::Observation& arrived : errors->process(std::move(*ideal)))
        keep(std::move(arrived), recording);
  }
  if (errors)
    for (slam::Observation& arrived : errors->flush()) keep(std::move(arrived), recording);
  recording.truth = recording::read_truth(folder / "recording");
  return recording;
}

tracking::Tracked track(const Recording& recording, const scenario::Scenario& scenario) {
  if (!recording.errors.empty() && recording.errors != errors_of(scenario))
    throw std::logic_error("the recording contains other sensor errors than those of the trial");
  tracking::Tracking tracking(scenario, recording.setup.calibration, recording.setup.X_WC_start);
  for (const slam::Observation& observation : recording.observations) {
    if (recording.errors.empty())
      tracking.process(observation);
    else
      tracking.step(observation);
  }
  return tracking.finish();
}

// The fraction of the recording until the filter diverged or the estimator failed.
double lasted_fraction(const Recording& recording, const tracking::Tracked& tracked) {
  const double end_s = slam::seconds(recording.observations.back().t);
  if (tracked.failed)
    return tracked.frames.empty() || end_s <= 0 ? 0 : slam::seconds(tracked.frames.back().report.t) / end_s;
  if (!tracked.failure()) return 1;
  const auto losses = tracked.losses();
  return end_s > 0 ? slam::seconds(losses.back().from) / end_s : 0;
}

const double kLn2Pi = std::log(2 * std::numbers::pi);

// Over the scored frames.
std::optional<double> mean_pose_nll(const score::ScoreContext& scored) {
  double sum = 0;
  auto pose = scored.run.estimate->begin();
  for (const score::PosePair& pair : scored.pairs) {
    while (pose->t != pair.t) ++pose;
    if (!pose->covariance) return std::nullopt;
    const auto nll = pose_nll(pair.X_true, pair.X_estimate, *pose->covariance);
    if (!nll) return std::nullopt;
    sum += *nll;
  }
  return sum / static_cast<double>(scored.pairs.size());
}

double mean_innovation_nll(const tracking::Tracked& tracked, double image_px2) {
  double sum = 0;
  for (const tracking::TrackedFrame& frame : tracked.frames) sum += innovation_nll(frame.report, image_px2);
  return sum / static_cast<double>(tracked.frames.size());
}

}  // namespace

std::string errors_of(const scenario::Scenario& scenario) {
  std::string text = fmt::format("seed: {}\n", scenario.seed);
  for (const auto& key : scenario::scenario_keys())
    if (key.name.starts_with("errors.")) text += key.name + ": " + key.print(scenario) + "\n";
  return text;
}

Recording load_identity(const fs::path& result_folder) {
  Recording recording;
  recording.name = name_of(result_folder);
  recording.hash = recording::Manifest(result_folder / "recording").hash();
  return recording;
}

Recording load(const fs::path& result_folder) { return load(result_folder, nullptr); }

Recording load(const fs::path& result_folder, const scenario::Scenario& scenario) {
  sensor_errors::SensorErrors errors(scenario.errors, scenario.seed);
  Recording recording = load(result_folder, &errors);
  recording.errors = errors_of(scenario);
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
  return (llt.matrixL().solve(error).squaredNorm() + log_determinant + 6 * kLn2Pi) / 2;
}

double nll(const slam::Nis& nis) { return (nis.value + nis.log_determinant + nis.dof * kLn2Pi) / 2; }

double innovation_nll(const slam::FrameReport& report, double image_px2) {
  double sum = 0;
  for (const slam::SensorInnovation& innovation : report.innovations)
    if (innovation.sensor != "vision") sum += nll(innovation.nis);  // matches count with the update's noise
  if (report.update) sum += nll(*report.update);
  const auto not_found = report.searched.size() - report.matched.size();
  return sum + static_cast<double>(not_found) * std::log(image_px2);
}

std::optional<Terms> terms(const score::ScoreContext& scored, const tracking::Tracked& tracked,
                           const score::Metrics& metrics, const slam::CameraIntrinsics& camera) {
  const auto rmse = metrics.at("rmse_m").value;
  if (scored.no_estimate || !rmse) return std::nullopt;
  const auto pose = mean_pose_nll(scored);
  if (!pose) return std::nullopt;
  return Terms{*pose, mean_innovation_nll(tracked, 1.0 * camera.width_px * camera.height_px), *rmse};
}

Trial run_trial(const Recording& recording, const scenario::ReadScenario& scenario) {
  const result::RunRecord record{scenario,
                                 {recording.walk.ending},
                                 recording.setup,
                                 recording.truth,
                                 track(recording, scenario.scenario),
                                 recording.hash};
  const score::Run run = result::score_input(record);
  const score::ScoreContext scored(run);
  Trial trial{result::ending_of(record), score::evaluate(scored), std::nullopt, 1};
  trial.lasted_fraction = lasted_fraction(recording, *record.tracked);
  trial.terms = terms(scored, *record.tracked, trial.metrics, recording.setup.calibration.camera);
  return trial;
}

}  // namespace sim::trials
