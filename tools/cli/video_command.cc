#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <optional>

#include "sim/bench/scenario.h"
#include "sim/stream/durable_file.h"
#include "sim/stream/seen.h"
#include "tools/cli/child.h"
#include "tools/cli/commands.h"
#include "tools/cli/live.h"
#include "tools/cli/progress.h"
#include "tools/cli/video_frame.h"

namespace cli {
namespace {

namespace bench = sim::bench;
namespace fs = std::filesystem;
namespace stream = sim::stream;

constexpr const char* kExamples = R"(
Examples:
  gaitslam video results/tangent_circle/seed-1
  gaitslam video results/tangent_circle/seed-1 --out walk.webm
The filter runs again on the recording, as it ran. From left to right: the head camera's image with the ellipses
in which landmarks were looked for and the patches that were found; the robot from outside (in a build with the
simulator: the true waist with the planned legs); the map from above. To RESULT/video.mp4 unless --out names a
.mp4 or .webm file.)";

struct Request {
  fs::path result;
  std::optional<std::string> out;
  bool force = false;
};

fs::path file_of(const Request& request) {
  const fs::path file = request.out ? fs::path(*request.out) : request.result / "video.mp4";
  if (file.extension() != ".mp4" && file.extension() != ".webm")
    throw UsageError(fmt::format("--out: expected a .mp4 or .webm file, not '{}'", file.string()));
  if (request.out && !request.force && fs::exists(file))
    throw UsageError(fmt::format("{}: exists already; --force replaces it", file.string()));
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  if (!fs::is_directory(folder)) throw UsageError(fmt::format("{}: no such folder", folder.string()));
  return file;
}

// The pictures on their way: a folder beside the video, taken away at the end.
class Pictures {
 public:
  explicit Pictures(const fs::path& video)
      : folder_((video.has_parent_path() ? video.parent_path() : fs::path(".")) /
                fmt::format(".{}.pictures-{}", video.filename().string(), ::getpid())) {
    fs::create_directories(folder_);
  }
  ~Pictures() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Pictures(const Pictures&) = delete;
  Pictures& operator=(const Pictures&) = delete;

  void add(const cv::Mat& picture) {
    const fs::path file = folder_ / fmt::format("{:06}.png", count_++);
    if (!cv::imwrite(file.string(), picture, {cv::IMWRITE_PNG_COMPRESSION, 1}))
      throw stream::FileError(file, "cannot be written");
  }
  /// One picture after another at this rate, by the program ffmpeg.
  void encode(const fs::path& video, double rate_hz) const {
    const fs::path made = folder_ / ("video" + video.extension().string());
    std::vector<std::string> arguments{"ffmpeg",
                                       "-loglevel",
                                       "error",
                                       "-framerate",
                                       fmt::format("{}", rate_hz),
                                       "-i",
                                       (folder_ / "%06d.png").string(),
                                       "-pix_fmt",
                                       "yuv420p",
                                       "-bitexact"};
    const bool webm = video.extension() == ".webm";
    const std::vector<std::string> codec =
        webm ? std::vector<std::string>{"-c:v", "libvpx-vp9", "-crf",      "32",
                                        "-b:v", "0",          "-deadline", "realtime"}
             : std::vector<std::string>{"-c:v",    "libx264", "-crf",      "23",
                                        "-preset", "fast",    "-movflags", "+faststart"};
    arguments.insert(arguments.end(), codec.begin(), codec.end());
    arguments.push_back(made.string());
    run_child(arguments);
    fs::rename(made, video);
  }

 private:
  fs::path folder_;
  int count_ = 0;
};

// The last of the poses that is not after t.
const stream::TimedPose* at(const std::vector<stream::TimedPose>& poses, slam::Stamp t) {
  const auto after = std::upper_bound(
      poses.begin(), poses.end(), t, [](slam::Stamp s, const stream::TimedPose& pose) { return s < pose.t; });
  return after == poses.begin() ? nullptr : &*std::prev(after);
}

int video(const Request& request) {
  if (!fs::is_directory(request.result / "recording"))
    throw UsageError(
        fmt::format("{}: has no recording/: expected the folder of a run", request.result.string()));
  const fs::path file = file_of(request);
  const bench::Scenario scenario = bench::read_scenario(request.result / "scenario.yaml").scenario;
  if (!scenario.slam) throw UsageError(fmt::format("{}: no filter ran", request.result.string()));
  const stream::Truth truth = stream::read_truth(request.result / "recording");
  stream::Seen seen(request.result / "recording", scenario.errors, scenario.seed);
  slam::Filter filter(*scenario.slam, seen.setup().calibration, seen.setup().X_WC_start, scenario.seed);
  const RobotView robot_view = robot_from_outside(scenario, GAITSLAM_MODELS);
  MapView map(truth.camera);
  Pictures pictures(file);
  ProgressLine progress("video of " + request.result.string());
  while (auto observation = seen.next()) {
    const slam::FrameReport& report = filter.step(*observation);
    std::vector<cv::Mat> panels{draw_view(*observation, report)};
    const stream::TimedPose* waist = at(truth.waist, observation->t);
    if (robot_view && waist) panels.push_back(robot_view(observation->t, waist->X));
    panels.push_back(map.draw(filter.estimate(), filter.map()));
    cv::Mat picture;
    cv::hconcat(panels, picture);
    pictures.add(picture);
    if (!truth.camera.empty())
      progress.show(slam::seconds(observation->t) / std::max(1e-3, slam::seconds(truth.camera.back().t)));
  }
  pictures.encode(file, seen.setup().camera_rate_hz);
  std::cout << file.string() << '\n';
  return 0;
}

}  // namespace

void add_video(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<Request>();
  CLI::App* command = app.add_subcommand("video", "Make a video of what the filter saw, sought and mapped");
  command->add_option("result", request->result, "a result folder, as results/tangent_circle/seed-1")
      ->required();
  command->add_option("--out", request->out, "a .mp4 or .webm file");
  command->add_flag("--force", request->force, "replace a file that exists");
  command->footer(kExamples);
  command->callback([request, &exit_code] { exit_code = video(*request); });
}

}  // namespace cli
