#include "sim/view/playback.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/files/json.h"
#include "sim/pages/run_data.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording.h"

namespace sim::view {
namespace {

namespace fs = std::filesystem;

/// The recording of a result; empty if it was not found.
fs::path recording_of(const fs::path& result, const std::string& hash) {
  if (fs::exists(result / "recording/manifest.csv")) return result / "recording";
  const fs::path above = fs::absolute(result).lexically_normal().parent_path() / "recording";
  if (!hash.empty() && fs::exists(above / "manifest.csv") && recording::Manifest(above).hash() == hash)
    return above;
  return {};
}

bool any_bodies(const std::vector<Frame>& frames) {
  return std::any_of(frames.begin(), frames.end(), [](const Frame& frame) { return !frame.bodies.empty(); });
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

void name_what_is_missing(Playback& playback, const fs::path& recording, bool simulator) {
  std::vector<std::string>& missing = playback.run.missing;
  if (!simulator)
    missing.emplace_back("Room and robot are not shown: this program was built without the simulator.");
  if (recording.empty())
    missing.emplace_back("Head images, feet and joint angles are not shown: this result has no recording.");
  else if (simulator && !any_bodies(playback.frames))
    missing.emplace_back("The robot is not shown: the recording has no joint angles.");
  if (std::none_of(playback.frames.begin(), playback.frames.end(),
                   [](const Frame& f) { return f.estimate.has_value(); }))
    missing.emplace_back("No estimate: there was no filter, or it left no estimate.");
}

std::string run_json(const Playback& playback) {
  Strips strips;
  std::string text = "{\"frames\":[";
  for (std::size_t i = 0; i < playback.frames.size(); ++i) {
    Frame shown = playback.frames[i];
    strips.add(shown);
    std::string frame = to_json(shown);
    if (!playback.images[i].empty()) frame.insert(1, "\"stored_image\":true,");
    text += (i == 0 ? "" : ",") + frame;
  }
  return text + "],\"strips\":" + files::json_text(strips_html(strips.figures())) + "}";
}

std::vector<ShownRun> runs_of(const std::vector<Playback>& results) {
  std::vector<ShownRun> runs;
  for (const Playback& result : results) runs.push_back(result.run);
  return runs;
}

Site site_of(const std::vector<Playback>& results) {
  if (results.size() > 1 && results[0].scenario != results[1].scenario)
    throw std::invalid_argument(
        fmt::format("view: the results are of {} and of {}, expected two of one scenario",
                    results[0].scenario, results[1].scenario));
  Site site(runs_of(results), {{"mode", "playback"}, {"control", false}});
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
  name_what_is_missing(playback, recording, robot.has_value());
  return playback;
}

PlaybackView::PlaybackView(const Access& access, const std::vector<Playback>& results)
    : site_(site_of(results)),
      server_(access, {[this](std::string_view path) { return site_.at(path, server_.access().token); }}) {}

}  // namespace sim::view
