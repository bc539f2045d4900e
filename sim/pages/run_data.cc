#include "sim/pages/run_data.h"

#include <fmt/core.h>

#include <cmath>

#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/files/tum.h"
#include "sim/result/score_file.h"
#include "sim/score/consistency.h"

namespace sim::pages {
namespace {

namespace fs = std::filesystem;

double seconds(std::chrono::nanoseconds t) { return 1e-9 * static_cast<double>(t.count()); }

Path path_of(const std::vector<files::TumRow>& rows) {
  Path path;
  for (const files::TumRow& row : rows) {
    path.t.push_back(seconds(row.t));
    path.x.push_back(row.X.translation().x());
    path.y.push_back(row.X.translation().y());
    path.z.push_back(row.X.translation().z());
    path.yaw.push_back(score::yaw(row.X.linear()));
  }
  return path;
}

Path read_path(const fs::path& file) { return path_of(files::read_tum(file)); }

score::Trajectory trajectory(const std::vector<files::TumRow>& rows) {
  score::Trajectory all;
  for (const files::TumRow& row : rows) all.push_back({row.t, row.X});
  return all;
}

// The standard deviation of the heading: of the orientation error's part along the world's vertical.
double sigma_yaw(const Eigen::Isometry3d& X_WC, const score::Matrix6d& covariance) {
  const Eigen::Vector3d vertical_C = X_WC.linear().transpose() * Eigen::Vector3d::UnitZ();
  const double variance = vertical_C.dot(covariance.topLeftCorner<3, 3>() * vertical_C);
  return variance < 0 ? 0 : std::sqrt(variance);
}

// Without a covariance there is neither envelope nor NEES: the figures leave out what is not a number.
void add(Errors& errors, const score::PosePair& pair, const std::optional<score::Matrix6d>& stated) {
  const score::Matrix6d covariance = stated.value_or(score::Matrix6d::Constant(NAN));
  const Eigen::Vector3d e = pair.X_estimate.translation() - pair.X_true.translation();
  const auto nees = score::pose_nees(pair.X_true, pair.X_estimate, covariance);
  errors.t.push_back(seconds(pair.t));
  errors.x.push_back(e.x());
  errors.y.push_back(e.y());
  errors.z.push_back(e.z());
  errors.distance.push_back(e.norm());
  errors.yaw.push_back(score::yaw(pair.X_estimate.linear() * pair.X_true.linear().transpose()));
  errors.sigma_x.push_back(std::sqrt(covariance(3, 3)));
  errors.sigma_y.push_back(std::sqrt(covariance(4, 4)));
  errors.sigma_z.push_back(std::sqrt(covariance(5, 5)));
  errors.sigma_yaw.push_back(sigma_yaw(pair.X_estimate, covariance));
  errors.nees_position.push_back(nees ? nees->position : NAN);
  errors.nees_orientation.push_back(nees ? nees->orientation : NAN);
}

Errors errors_of(const std::vector<files::TumRow>& truth, const std::vector<files::TumRow>& estimate) {
  Errors errors;
  std::size_t row = 0;
  for (const score::PosePair& pair : score::pair_by_stamp(trajectory(truth), trajectory(estimate))) {
    while (estimate[row].t != pair.t) ++row;
    add(errors, pair, estimate[row].covariance);
  }
  return errors;
}

std::optional<Table> table_if_there(const fs::path& file) {
  if (!fs::exists(file)) return std::nullopt;
  return Table(file);
}

/// The estimated waist: the camera is as far from it as planned at the start.
std::optional<Path> waist_of_estimate(const fs::path& folder) {
  if (!fs::exists(folder / "estimate.tum")) return std::nullopt;
  const auto waist = files::read_tum(folder / "waist_plan.tum"),
             camera = files::read_tum(folder / "plan.tum");
  auto estimate = files::read_tum(folder / "estimate.tum");
  if (waist.empty() || camera.empty()) return std::nullopt;
  const Eigen::Isometry3d X_CB = camera.front().X.inverse() * waist.front().X;
  for (files::TumRow& row : estimate) row.X = row.X * X_CB;
  return path_of(estimate);
}

void read_steering(RunData& run) {
  run.waist_desired = read_path(run.folder / "waist_desired.tum");
  run.waist_estimate = waist_of_estimate(run.folder);
  run.corrected_steps = table_if_there(run.folder / "corrected_steps.csv");
}

}  // namespace

std::optional<double> RunData::metric(const std::string& name) const {
  const auto& metrics = score.at("metrics");
  if (!metrics.contains(name) || !metrics[name]["value"].is_number()) return std::nullopt;
  return metrics[name]["value"].get<double>();
}

RunData read_run(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw files::FileError(folder, "no such result folder");
  RunData run;
  run.folder = folder;
  run.recording = folder / "recording";
  const files::Json score = result::read_whole_score(folder / "score.json"),
                    timing = files::read_json(folder / "timing.json");
  run.score = score.value();
  run.about = result::read_about(folder / "about.json");
  if (const auto median = timing.find("frame_cpu_ms_median")) run.frame_cpu_ms_median = median->number();
  run.scenario_yaml = files::read_text(folder / "scenario.yaml", files::kMostOfYaml);
  run.label = fmt::format("{}, seed {}", score.at("scenario").text(), score.at("seed").whole());
  if (const auto estimator = score.find("estimator"); estimator && estimator->text() != "filter")
    run.label += ", " + estimator->text();
  const auto truth = files::read_tum(folder / "truth.tum");
  run.truth = path_of(truth);
  run.plan = read_path(folder / "plan.tum");
  run.waist_truth = read_path(folder / "waist_truth.tum");
  run.waist_plan = read_path(folder / "waist_plan.tum");
  if (const fs::path file = folder / "estimate_cov.txt"; fs::exists(file)) {
    const auto estimate = files::read_tum(file);
    run.estimate = path_of(estimate);
    run.errors = errors_of(truth, estimate);
  }
  if (fs::exists(folder / "waist_desired.tum")) read_steering(run);
  run.frames = table_if_there(folder / "frames.csv");
  run.map = table_if_there(folder / "map.csv");
  run.maps = table_if_there(folder / "map_over_time.csv");
  run.searches = table_if_there(folder / "searches.csv");
  run.feet = table_if_there(folder / "feet.csv");
  run.frame_times = table_if_there(folder / "timing.csv");
  return run;
}

}  // namespace sim::pages
