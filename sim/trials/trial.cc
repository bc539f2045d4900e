#include "sim/trials/trial.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "sim/files/atomic_file.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/result/result.h"
#include "sim/result/score_file.h"
#include "sim/scenario/keys.h"

namespace sim::trials {
namespace {

namespace fs = std::filesystem;

// Keeps the observation with a view of its image, which has no reference counter for threads to share.
void keep(slam::Observation observation, Recording& recording) {
  if (!observation.image.empty()) {
    recording.pictures.push_back(observation.image);
    const cv::Mat& owner = recording.pictures.back();
    observation.image = cv::Mat(owner.rows, owner.cols, owner.type(), owner.data, owner.step);
  }
  recording.observations.push_back(std::move(observation));
}

// The keys errors.* and the seed, which determine the sensor errors.
std::string errors_of(const scenario::Scenario& scenario) {
  std::string text = fmt::format("seed: {}\n", scenario.seed);
  for (const auto& key : scenario::scenario_keys())
    if (key.name.starts_with("errors.")) text += key.name + ": " + key.print(scenario) + "\n";
  return text;
}

tracking::Tracked track(const Recording& recording, const scenario::Scenario& scenario) {
  if (!recording.errors.empty() && recording.errors != errors_of(scenario))
    throw std::logic_error("the recording contains other sensor errors than those of the trial");
  const recording::RecordingSetup& setup = recording.setup;
  tracking::Tracking tracking(scenario, setup.calibration, setup.X_WC_start, setup.camera_rate_hz, setup.rig);
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
  return sum / static_cast<double>(scored.pairs.size());
}

}  // namespace

Recording load(const fs::path& folder, const scenario::Scenario* with_errors) {
  Recording recording;
  recording.walk = *result::read_about_of_walk(folder / "about.json").walk;
  recording::RecordingReader reader(folder / "recording");
  recording.setup = reader.setup();
  recording.hash = reader.hash();
  if (!with_errors) {
    while (auto ideal = reader.next()) keep(std::move(*ideal), recording);
  } else {
    sensor_errors::SensorErrors errors(with_errors->errors, with_errors->seed);
    while (auto ideal = reader.next())
      for (slam::Observation& arrived : errors.process(std::move(*ideal)))
        keep(std::move(arrived), recording);
    for (slam::Observation& arrived : errors.flush()) keep(std::move(arrived), recording);
    recording.errors = errors_of(*with_errors);
  }
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
    const int unmatched = static_cast<int>(frame.report.searched.size()) - matched_dof / 2;
    if (unmatched > 0)
      sums["vision"].nll += unmatched * std::log(area_px2), sums["vision"].dof += 2 * unmatched;
  }
  double total = 0;
  for (const auto& [sensor, sum] : sums) total += sum.nll / sum.dof;
  return sums.empty() || !std::isfinite(total) ? std::nullopt : std::optional(total);
}

TrialRecord run_trial(const Recording& recording, const scenario::ReadScenario& scenario,
                      const std::string& key) {
  result::RunRecord run{scenario,     {recording.walk.ending}, recording.setup, recording.truth,
                        std::nullopt, recording.hash};
  if (scenario.scenario.slam) run.tracked = track(recording, scenario.scenario);
  const score::Run input = result::score_input(run);
  const score::ScoreContext scored(input);
  const scenario::Ended ended = result::ending_of(run);
  TrialRecord record{key,
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

void write_tasks(const std::filesystem::path& file, const TaskFile& tasks) {
  std::string text = tasks.purpose + "\n";
  for (const Task& task : tasks.tasks)
    text +=
        nlohmann::json{{"key", task.key}, {"scenario", task.scenario}, {"recording", task.recording.string()}}
            .dump() +
        "\n";
  files::write_atomically(file, text);
}

TaskFile read_tasks(const std::filesystem::path& file) {
  std::istringstream in(files::read_text(file));
  TaskFile tasks;
  if (!std::getline(in, tasks.purpose)) throw files::FileError(file, "cannot be read");
  for (std::string line; std::getline(in, line);) {
    const files::Json task(fmt::format("{}:{}", file.string(), tasks.tasks.size() + 2), line);
    tasks.tasks.push_back({task.at("key").text(), task.at("scenario").text(), task.at("recording").text()});
  }
  return tasks;
}

std::vector<std::string> value_names() {
  std::vector<std::string> names;
  for (const auto& metric : score::metric_definitions()) names.emplace_back(metric.name);
  names.insert(names.end(), {"pose_nll", "innovation_nll"});
  return names;
}

std::shared_ptr<Runner::Loaded> Runner::find(const std::string& name) {
  const std::scoped_lock lock(mutex_);
  if (!keeps_all_ && !loaded_.contains(name)) loaded_.clear();
  std::shared_ptr<Loaded>& loaded = loaded_[name];
  if (!loaded) loaded = std::make_shared<Loaded>();
  return loaded;
}

// A recording is loaded with the sensor errors of the first trial that needs it. If another trial has other
// errors, it is loaded without any, and from then on each trial applies its own.
std::shared_ptr<const Recording> Runner::load(const Task& task, const scenario::ReadScenario& read) {
  const auto loaded = find(task.recording.empty() ? cache_.key(read.scenario) : task.recording.string());
  const std::scoped_lock lock(loaded->mutex);
  const auto load_from = [&](const std::filesystem::path& folder) {
    loaded->recording =
        std::make_shared<const Recording>(trials::load(folder, loaded->recording ? nullptr : &read.scenario));
  };
  const Recording* const now = loaded->recording.get();
  if (!now || (!now->errors.empty() && now->errors != errors_of(read.scenario)))
    task.recording.empty() ? cache_.open(read, load_from) : load_from(task.recording);
  return loaded->recording;
}

TrialRecord Runner::run(const Task& task) {
  const scenario::ReadScenario read = scenario::read_scenario_text(task.scenario, "task.yaml");
  try {
    const auto recording = load(task, read);
    const scenario::Ended& walk = recording->walk;
    if (walk.ending == scenario::Ending::failed)  // there is nothing to replay
      return {task.key, read.scenario.seed, std::string(name_of(walk.ending)), walk.cause, {}};
    return run_trial(*recording, read, task.key);
  } catch (const files::FileError&) {
    throw;  // a fault of the machine, such as a full disk
  } catch (const std::exception& e) {
    return {task.key, read.scenario.seed, std::string(name_of(scenario::Ending::not_started)), e.what(), {}};
  }
}

RunTasks in_threads(int threads) {
  const auto runner = std::make_shared<Runner>(true);
  return [threads, runner](const std::vector<Task>& tasks, TrialLog& log) {
    std::atomic<std::size_t> next{0};
    std::vector<std::exception_ptr> faults(tasks.size());
    const auto work = [&] {
      for (std::size_t i = next++; i < tasks.size(); i = next++) {
        try {
          log.add(runner->run(tasks[i]));
        } catch (...) {
          faults[i] = std::current_exception();
        }
      }
    };
    {
      std::vector<std::jthread> others;
      for (int k = 1; k < std::min(threads, static_cast<int>(tasks.size())); ++k) others.emplace_back(work);
      work();
    }
    for (const std::exception_ptr& fault : faults)
      if (fault) std::rethrow_exception(fault);
  };
}

}  // namespace sim::trials
