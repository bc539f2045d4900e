#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "sim/files/atomic_file.h"
#include "sim/recording/filter_input.h"
#include "sim/scenario/scenario.h"
#include "sim/view/session.h"
#include "sim/view/video_frame.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/child.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/shared/interruption.h"
#include "tools/cli/shared/model_files.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/out_folder.h"

namespace cli {
namespace {

namespace files = sim::files;
namespace recording = sim::recording;
namespace scenario = sim::scenario;
namespace fs = std::filesystem;

constexpr const char* kVideoExamples = R"(
Examples:
  gaitslam video results/tangent_circle/seed-1
  gaitslam video results/tangent_circle/seed-1 --out walk.webm
The filter runs again on the recording. The video shows, from left to right, the image of the head camera with the
search ellipses of the landmarks and the patches that were matched; the robot from outside, in a build with the
simulator, with its true waist and its measured joint angles; and the map from above. The video is RESULT/video.mp4
unless --out names a .mp4 or .webm file. Folders that other programs recorded are not accepted.)";

struct VideoRequest {
  fs::path result;
  std::optional<std::string> out;
  bool force = false;
};

fs::path file_of(const VideoRequest& request) {
  const fs::path file = request.out ? fs::path(*request.out) : request.result / "video.mp4";
  if (file.extension() != ".mp4" && file.extension() != ".webm")
    throw UsageError(fmt::format("--out: expected a .mp4 or .webm file, not '{}'", file.string()));
  if (request.out)
    require_new_file(file, request.force);
  else if (sim::files::has_marker(request.result) && !request.force)
    sim::files::list_outputs(request.result, {"video.mp4"});
  else
    require_new_file(file, request.force);
  return file;
}

// Encodes pictures by the program ffmpeg. The file appears, whole, when finish() is called.
class Encoder {
 public:
  Encoder(const fs::path& video, double rate_hz)
      : video_(video), rate_hz_(rate_hz), partial_(video.string() + ".frames") {}
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  void add(const cv::Mat3b& picture) {
    if (!ffmpeg_) ffmpeg_.emplace(command(picture.size()));
    ffmpeg_->write({reinterpret_cast<const char*>(picture.data), 3 * picture.total()});
  }
  void finish() {
    if (!ffmpeg_) throw UsageError("the recording has no frames");
    ffmpeg_->finish();
    fs::rename(made_, video_);
  }

 private:
  std::vector<std::string> command(const cv::Size& size) const {
    std::vector<std::string> words{"ffmpeg",
                                   "-loglevel",
                                   "error",
                                   "-xerror",
                                   "-y",
                                   "-f",
                                   "rawvideo",
                                   "-pix_fmt",
                                   "bgr24",
                                   "-video_size",
                                   fmt::format("{}x{}", size.width, size.height),
                                   "-framerate",
                                   fmt::format("{}", rate_hz_),
                                   "-i",
                                   "-",
                                   "-pix_fmt",
                                   "yuv420p",
                                   "-bitexact"};
    using Words = std::vector<std::string>;
    const Words codec =
        video_.extension() == ".webm"
            ? Words{"-c:v", "libvpx-vp9", "-crf",     "32",        "-b:v",
                    "0",    "-deadline",  "realtime", "-cpu-used", "8"}
            : Words{"-c:v", "libx264", "-crf", "23", "-preset", "fast", "-movflags", "+faststart"};
    words.insert(words.end(), codec.begin(), codec.end());
    words.push_back(made_.string());
    return words;
  }

  fs::path video_;
  double rate_hz_;
  files::AtomicFolder partial_;
  fs::path made_ = partial_.path() / video_.filename();
  std::optional<FedChild> ffmpeg_;
};

// The last of the poses that is not after t.
const files::TimedPose* at(const std::vector<files::TimedPose>& poses, slam::Stamp t) {
  const auto after = std::upper_bound(poses.begin(), poses.end(), t,
                                      [](slam::Stamp s, const files::TimedPose& pose) { return s < pose.t; });
  return after == poses.begin() ? nullptr : &*std::prev(after);
}

int video(const VideoRequest& request) {
  if (!fs::is_directory(request.result / "recording"))
    throw UsageError(
        fmt::format("{}: has no recording/: expected the folder of a run", request.result.string()));
  const fs::path file = file_of(request);
  const scenario::Scenario scenario = scenario::read_scenario(request.result / "scenario.yaml").scenario;
  if (!scenario.slam) throw UsageError(fmt::format("{}: no filter ran", request.result.string()));
  const recording::Truth truth = recording::read_truth(request.result / "recording");
  recording::FilterInput input(request.result / "recording", scenario.errors, scenario.seed);
  slam::Filter filter(*scenario.slam, input.setup().calibration, input.setup().X_WC_start, scenario.seed);
  const sim::view::RobotView robot_view =
      sim::view::robot_from_outside(scenario, request.result / "recording", standard_models());
  sim::view::MapView map(truth.camera);
  Encoder encoder(file, input.setup().camera_rate_hz);
  const OnInterrupt on_interrupt("nothing was written; rerun the command");
  ProgressLine progress("video of " + request.result.string());
  while (auto observation = input.next()) {
    const slam::FrameReport& report = filter.step(*observation);
    std::vector<cv::Mat> panels{sim::view::draw_view(*observation, report)};
    const files::TimedPose* waist = at(truth.waist, observation->t);
    if (robot_view && waist) panels.push_back(robot_view(observation->t, waist->X));
    panels.push_back(map.draw(filter.estimate(), filter.map()));
    cv::Mat picture;
    cv::hconcat(panels, picture);
    encoder.add(picture);
    if (!truth.camera.empty())
      progress.show(slam::seconds(observation->t) / std::max(1e-3, slam::seconds(truth.camera.back().t)));
  }
  encoder.finish();
  std::cout << file.string() << '\n';
  return 0;
}

}  // namespace

void add_video(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<VideoRequest>();
  CLI::App* command =
      app.add_subcommand("video", "Make a video of the camera images, the matched landmarks and the map");
  add_result(*command, request->result);
  command->add_option("--out", request->out, "the .mp4 or .webm file to write");
  command->add_flag("--force", request->force, "replace an existing file");
  command->footer(kVideoExamples);
  command->callback([request, &exit_code] { exit_code = video(*request); });
}

}  // namespace cli
