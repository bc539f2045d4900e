#include "sim/view/playback.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/files/text.h"
#include "sim/recording/image_size.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording.h"
#include "sim/view/result_frames.h"

namespace sim::view {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostImageBytes = 64 << 20;

/// The recording that a result was made from; empty where it is not to be found.
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

std::vector<Moment> faults_in_score(const nlohmann::ordered_json& score, const char* kind) {
  std::vector<Moment> moments;
  const auto tracking = score.find("tracking");
  if (tracking == score.end() || !tracking->is_object() || !tracking->contains(kind)) return moments;
  for (const auto& one : (*tracking)[kind])
    moments.push_back({one.value("from_s", 0.0), kind, fmt::format("{}: {}", kind, one.value("cause", ""))});
  return moments;
}

std::vector<Moment> moments_of(const pages::RunData& data, const scenario::Scenario& scenario,
                               double end_s) {
  std::vector<Moment> all = faults_of(scenario);
  if (const auto closed = data.metric("loop_time_s")) all.push_back({*closed, "closure", "loop closed"});
  for (const char* const kind : {"lost", "suspect"})
    for (const Moment& moment : faults_in_score(data.score, kind)) all.push_back(moment);
  const std::string ending = data.score.value("ending", "");
  if (ending != "completed")
    all.push_back({end_s, "end", data.about.cause.empty() ? ending : ending + ": " + data.about.cause});
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
    missing.emplace_back("There is no estimate: no filter ran, or it left none.");
}

Resource png(const fs::path& file) {
  auto bytes = std::make_shared<const std::string>(files::read_text(file, kMostImageBytes));
  if (!recording::image_size(*bytes) || !bytes->starts_with("\x89PNG"))
    throw files::FileError(file, "is no PNG image");
  return {"image/png", std::move(bytes)};
}

std::string run_json(const Playback& playback) {
  std::string text = "{\"frames\":[";
  for (std::size_t i = 0; i < playback.frames.size(); ++i) {
    std::string frame = to_json(playback.frames[i]);
    if (!playback.images[i].empty()) frame.insert(1, "\"stored_image\":true,");
    text += (i == 0 ? "" : ",") + frame;
  }
  return text + "]}";
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
    site.add_list(fmt::format("/image/{}", i),
                  [images = results[i].images](std::size_t k) -> std::optional<Resource> {
                    if (k >= images.size() || images[k].empty()) return std::nullopt;
                    return png(images[k]);
                  });
  }
  return site;
}

}  // namespace

Playback read_playback(const fs::path& result, const MakeRobot& make_robot) {
  const pages::RunData data = pages::read_run(result);
  const scenario::Scenario scenario = scenario::read_scenario(result / "scenario.yaml").scenario;
  Playback playback;
  playback.scenario = data.score.value("scenario", "?");
  playback.frames = read_result_frames(result, data);
  const fs::path recording = recording_of(result, data.about.recording);
  std::optional<RobotModel> robot;
  if (make_robot) robot = make_robot(scenario);
  if (!recording.empty()) {
    add_recorded(playback.frames, recording, robot ? &*robot : nullptr);
    playback.run.camera = recording::RecordingReader(recording).setup().calibration.camera;
  }
  playback.images = recording.empty() ? std::vector<fs::path>(playback.frames.size())
                                      : image_files(playback.frames, recording);
  playback.run.label = data.label;
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
