#include "sim/view/playback.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/pages/run_data.h"
#include "sim/recording/manifest.h"

namespace sim::view {
namespace {

namespace fs = std::filesystem;

/// The last row of a CSV file of the recording's at or before a time. Times are asked for in order.
class RowsOverTime {
 public:
  RowsOverTime(const fs::path& file, std::size_t fields) : reader_(file), row_(fields) {
    more_ = reader_.next();
    if (more_ && reader_.fields() != fields + 1)
      throw files::FileError(file, 1,
                             fmt::format("has {} columns, expected {}", reader_.fields(), fields + 1));
  }
  const std::vector<double>* at(slam::Stamp t) {
    for (; more_ && slam::Stamp(reader_.integer(0)) - recording::kEpoch <= t; more_ = reader_.next()) {
      any_ = true;
      for (std::size_t i = 0; i < row_.size(); ++i) row_[i] = reader_.number(1 + i);
    }
    return any_ ? &row_ : nullptr;
  }

 private:
  files::CsvReader reader_;
  std::vector<double> row_;
  bool more_ = false, any_ = false;
};

void add_feet(std::vector<Frame>& frames, const std::vector<recording::TrueFeet>& feet) {
  std::size_t row = 0;
  for (Frame& frame : frames) {
    while (row + 1 < feet.size() && feet[row + 1].t <= frame.t) ++row;
    if (row < feet.size()) frame.feet = {place_of(feet[row].left), place_of(feet[row].right)};
  }
}

void add_zmp(std::vector<Frame>& frames, const fs::path& file) {
  if (!fs::exists(file)) return;
  RowsOverTime forces(file, 12);
  for (Frame& frame : frames) {
    const std::vector<double>* const row = forces.at(frame.t);
    if (!row || !frame.feet) continue;
    const auto sole = [&](std::size_t foot) {
      const double* const f = row->data() + 6 * foot;
      return SoleForce{(*frame.feet)[foot].truth, {f[0], f[1], f[2]}, {f[3], f[4], f[5]}};
    };
    frame.zmp = zero_moment_point({sole(0), sole(1)});
  }
}

void add_bodies(std::vector<Frame>& frames, const fs::path& file, const std::vector<files::TimedPose>& waist,
                const RobotModel& robot) {
  const std::size_t joints = files::CsvReader(file).titles().size() - 1;
  RowsOverTime encoders(file, joints);
  std::size_t row = 0;
  for (Frame& frame : frames) {
    while (row < waist.size() && waist[row].t < frame.t) ++row;
    const std::vector<double>* const q = encoders.at(frame.t);
    if (!q || row == waist.size() || waist[row].t != frame.t) continue;
    frame.bodies = robot.poses(
        Eigen::Map<const Eigen::VectorXd>(q->data(), static_cast<Eigen::Index>(joints)), waist[row].X);
  }
}

/// The recording of a result; empty if it was not found.
fs::path recording_of(const fs::path& result, const std::string& hash) {
  if (fs::exists(result / "recording/manifest.csv")) return result / "recording";
  const fs::path above = fs::absolute(result).lexically_normal().parent_path() / "recording";
  if (!hash.empty() && fs::exists(above / "manifest.csv") && recording::Manifest(above).hash() == hash)
    return above;
  return {};
}

std::vector<Moment> moments_of(const pages::RunData& data, const scenario::Scenario& scenario, double end_s) {
  std::vector<Moment> all = faults_of(scenario);
  if (const auto closed = data.metric("loop_time_s")) all.push_back({*closed, "closure", "loop closed"});
  for (const pages::TrackingFault& fault : data.faults)
    all.push_back({fault.from_s, fault.kind, fmt::format("{}: {}", fault.kind, fault.cause)});
  if (data.ending != "completed")
    all.push_back(
        {end_s, "end", data.about.cause.empty() ? data.ending : data.ending + ": " + data.about.cause});
  std::stable_sort(all.begin(), all.end(), [](const Moment& a, const Moment& b) { return a.t_s < b.t_s; });
  return all;
}

std::vector<std::string> missing_of(const Playback& playback, bool recording, bool simulator) {
  const auto none = [&](const auto& has) {
    return std::none_of(playback.frames.begin(), playback.frames.end(), has);
  };
  std::vector<std::string> missing;
  if (!simulator)
    missing.emplace_back("Room and robot are not shown: this program was built without the simulator.");
  if (!recording)
    missing.emplace_back("Head images, feet and joint angles are not shown: this result has no recording.");
  else if (simulator && none([](const Frame& frame) { return !frame.bodies.empty(); }))
    missing.emplace_back("The robot is not shown: the recording has no joint angles.");
  if (none([](const Frame& frame) { return frame.estimate.has_value(); }))
    missing.emplace_back("No estimate: there was no filter, or it left no estimate.");
  return missing;
}

std::string run_json(const Playback& playback) {
  Strips strips;
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < playback.frames.size(); ++i) {
    Frame shown = playback.frames[i];
    strips.add(shown);
    frames.push_back(to_json(shown));
    if (!playback.images[i].empty()) frames.back()["stored_image"] = true;
  }
  return files::json_text({{"frames", frames}, {"strips", strips_html(strips.figures())}});
}

Site site_of(const std::vector<Playback>& results) {
  if (results.size() > 1 && results[0].scenario != results[1].scenario)
    throw std::invalid_argument(
        fmt::format("view: the results are of {} and of {}, expected two of one scenario",
                    results[0].scenario, results[1].scenario));
  std::vector<ShownRun> runs;
  for (const Playback& result : results) runs.push_back(result.run);
  Site site(runs, {{"mode", "playback"}, {"control", false}});
  for (std::size_t i = 0; i < results.size(); ++i) {
    site.add(fmt::format("/run/{}", i), json_resource(run_json(results[i])));
    site.add_list(
        fmt::format("/image/{}", i),
        [images = results[i].images,
         pictures = results[i].pictures](std::size_t k) -> std::optional<Resource> {
          if (k >= images.size() || images[k].empty() || !pictures) return std::nullopt;
          return Resource{"image/png", std::make_shared<const std::string>(pictures->png(images[k]))};
        });
  }
  return site;
}

}  // namespace

FootPlace place_of(const recording::TrueFoot& foot) {
  return {foot.truth, foot.plan, foot.planned_down, foot.load_n};
}

void add_recorded(std::vector<Frame>& frames, const fs::path& recording, const RobotModel* robot) {
  const recording::Truth truth = recording::read_truth(recording);
  add_feet(frames, truth.feet);
  add_zmp(frames, recording / "mav0/forces0/data.csv");
  const fs::path encoders = recording / "mav0/encoders0/data.csv";
  if (robot && fs::exists(encoders)) add_bodies(frames, encoders, truth.waist, *robot);
}

std::vector<Frame> read_recorded_frames(const fs::path& recording, const RobotModel* robot) {
  const recording::Truth truth = recording::read_truth(recording);
  std::vector<Frame> frames(truth.camera.size());
  for (std::size_t i = 0; i < frames.size(); ++i)
    frames[i].t = truth.camera[i].t, frames[i].truth = truth.camera[i].X;
  add_recorded(frames, recording, robot);
  return frames;
}

Playback read_playback(const fs::path& result, const MakeRobot& make_robot) {
  const pages::RunData data = pages::read_run(result);
  const scenario::Scenario scenario = scenario::read_scenario(result / "scenario.yaml").scenario;
  Playback playback;
  playback.scenario = data.scenario;
  playback.frames = data.frames;
  if (data.frames.empty())
    throw files::FileError(result / "truth.tum", "has no pose, expected one for each frame");
  const fs::path recording = recording_of(result, data.about.recording);
  std::optional<RobotModel> robot;
  if (make_robot) robot = make_robot(scenario);
  if (!recording.empty()) {
    add_recorded(playback.frames, recording, robot ? &*robot : nullptr);
    playback.run.camera = recording::RecordingReader(recording).setup().calibration.camera;
    playback.pictures = std::make_shared<const pages::Pictures>(recording);
  }
  playback.images = recording.empty() ? std::vector<fs::path>(playback.frames.size())
                                      : pages::image_files(playback.frames, recording);
  playback.run.label = data.label();
  playback.run.duration_s = slam::seconds(playback.frames.back().t);
  playback.run.moments = moments_of(data, scenario, playback.run.duration_s);
  if (robot) playback.run.model = robot->model;
  playback.run.missing = missing_of(playback, !recording.empty(), robot.has_value());
  return playback;
}

PlaybackView::PlaybackView(const Access& access, const std::vector<Playback>& results)
    : site_(site_of(results)),
      server_(access, {[this](std::string_view path) { return site_.at(path, server_.access().token); }}) {}

}  // namespace sim::view
