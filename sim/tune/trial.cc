#include "sim/tune/trial.h"

#include <fmt/format.h>

#include <stdexcept>

#include "sim/recording/manifest.h"
#include "sim/result/about_file.h"
#include "sim/result/score_input.h"
#include "sim/scenario/keys.h"
#include "sim/tune/terms.h"

namespace sim::tune {
namespace {

namespace fs = std::filesystem;

std::string name_of(const fs::path& result_folder) {
  const fs::path folder = fs::absolute(result_folder / "x").lexically_normal().parent_path();
  return (folder.parent_path().filename() / folder.filename()).string();
}

// Keeps the observation with a view of its image: a view has no reference counter that threads would share.
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
  recording.scenario = scenario::read_scenario(folder / "scenario.yaml");
  recording.walk_ending = result::read_about_of_walk(folder / "about.json").walk->ending;
  recording::RecordingReader reader(folder / "recording");
  recording.setup = reader.setup();
  recording.hash = reader.hash();
  while (auto ideal = reader.next()) {
    if (!errors)
      keep(std::move(*ideal), recording);
    else
      for (slam::Observation& arrived : errors->take(std::move(*ideal))) keep(std::move(arrived), recording);
  }
  if (errors)
    for (slam::Observation& arrived : errors->flush()) keep(std::move(arrived), recording);
  recording.truth = recording::read_truth(folder / "recording");
  return recording;
}

tracking::Tracked track(const Recording& recording, const scenario::Scenario& scenario) {
  if (!recording.errors.empty() && recording.errors != errors_of(scenario))
    throw std::logic_error("the recording contains other sensor errors than the trial asks for");
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

}  // namespace

std::size_t Recording::bytes() const {
  std::size_t sum = 0;
  for (const cv::Mat& picture : pictures) sum += picture.total();
  return sum;
}

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

Trial run_trial(const Recording& recording, const scenario::ReadScenario& scenario) {
  result::RunRecord record{scenario,
                           {recording.walk_ending},
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

}  // namespace sim::tune
