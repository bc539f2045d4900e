#include <fmt/ranges.h>
#include <signal.h>
#include <sys/wait.h>

#include <iostream>

#include "sim/export/export.h"
#include "sim/files/atomic_file.h"
#include "sim/recording/recording.h"
#include "sim/tracking/tracking.h"
#include "sim/view/session.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/jobs.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/out_folder.h"

namespace cli {
namespace {

constexpr const char* kExportExamples = R"(Examples:
  gaitslam export results/tangent_circle/seed-1 --format euroc --out DIR
  gaitslam export results/tangent_circle/seed-1 --format orbslam3 --undistort
The export contains the filter's input, including sensor errors. Its folder, RESULT/export/FORMAT by default, contains
a README.md with the command line for the target program, and session-1, ... if the scenario has sessions. Folders
recorded by other programs (EuRoC/ASL) cannot be exported; gaitslam replay reads them.)";

struct ExportRequest : OutRequest {
  fs::path result;
  std::string format;
  bool undistort = false;
};

void require_recording(const fs::path& result) {
  if (!fs::is_directory(result / "recording"))
    throw UsageError("{}: has no recording/, expected the folder of a run", result.string());
}

int export_result(ExportRequest& request) {
  require_one_of(exports::export_formats(), request.format, "--format");
  require_recording(request.result);
  const scenario::Scenario scenario = scenario::read_scenario(request.result / "scenario.yaml").scenario;
  const OutFolder out(request, request.result / "export" / request.format, OutUse::result);
  require_separate(out.path(), request.result);
  const auto export_to = [&](const fs::path& result, const scenario::Scenario& walked,
                             const fs::path& folder) {
    ProgressLine progress(fmt::format("export of {}", result.string()));
    exports::export_run(
        {result, walked.name, walked.seed, walked.errors, true, request.undistort,
         request.format == "mcap" ? view::robot_description(walked, standard_models()) : nullptr,
         [&](double part) { progress.show(part); },
         [](const std::string& what) { std::cerr << "warning: " << what << '\n'; }},
        request.format, folder);
  };
  export_to(request.result, scenario, out.path());
  for (std::size_t i = 1; i <= scenario.sessions.size(); ++i) {
    const fs::path name = fmt::format("session-{}", i), session = request.result / name;
    export_to(session, scenario::read_scenario(session / "scenario.yaml").scenario, out.path() / name);
  }
  std::cout << fmt::format("exported to {0}; see {0}/README.md for how to use it\n", out.path().string());
  return 0;
}

constexpr const char* kVideoExamples = R"(Examples:
  gaitslam video results/tangent_circle/seed-1 --out walk.webm
The filter runs again on the recording. On the left, the video shows the head camera's image with the search ellipses
of the landmarks and the matched patches. On the right, in a build with the simulator, it shows the robot from outside,
with its true waist pose and measured joint angles. gaitslam view also shows the map. The video is written to
RESULT/video.mp4 unless --out names a .mp4 or .webm file. There is no video for folders recorded by other programs
(EuRoC/ASL); gaitslam replay reads them.)";

struct VideoRequest : OutRequest {
  fs::path result;
};

fs::path file_of(const VideoRequest& request) {
  const fs::path file = request.out ? fs::path(*request.out) : request.result / "video.mp4";
  if (file.extension() != ".mp4" && file.extension() != ".webm")
    throw UsageError("--out: expected a .mp4 or .webm file, not '{}'", file.string());
  require_new_file(file, request.force);
  return file;
}

/// Encodes pictures with the program ffmpeg. The complete file appears when finish() is called.
class Encoder {
 public:
  Encoder(const fs::path& video, double rate_hz)
      : video_(video), rate_hz_(rate_hz), partial_(video.string() + ".frames") {
    ::signal(SIGPIPE, SIG_IGN);  // add() reports if ffmpeg ends early
  }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;
  ~Encoder() {
    if (ffmpeg_) ::pclose(ffmpeg_);
  }

  void add(const cv::Mat3b& picture) {
    if (!ffmpeg_) ffmpeg_ = ::popen(command(picture.size()).c_str(), "w");
    if (!ffmpeg_) throw std::runtime_error("ffmpeg cannot be started");
    if (std::fwrite(picture.data, 3, picture.total(), ffmpeg_) == picture.total()) return;
    require_success();
    throw std::runtime_error("ffmpeg ended early");
  }
  void finish() {
    if (!ffmpeg_) throw UsageError("the recording has no frames");
    require_success();
    files::publish(made_, video_);
  }

 private:
  std::string command(const cv::Size& size) const {
    return fmt::format(
        "exec ffmpeg -loglevel error -xerror -y -f rawvideo -pix_fmt bgr24 -video_size {}x{} -framerate {} "
        "-i - -pix_fmt yuv420p -bitexact {} {} 2>{}",
        size.width, size.height, rate_hz_,
        video_.extension() == ".webm" ? "-c:v libvpx-vp9 -crf 32 -b:v 0 -deadline realtime -cpu-used 8"
                                      : "-c:v libx264 -crf 23 -preset fast -movflags +faststart",
        files::shell_word(made_.string()), files::shell_word((scratch_ / "errors").string()));
  }

  /// Closes ffmpeg's input and waits for it to end.
  void require_success() {
    const int status = ::pclose(std::exchange(ffmpeg_, nullptr));
    if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
      throw std::runtime_error("ffmpeg cannot be run; install Debian's package ffmpeg");
    const std::string errors = files::read_text(scratch_ / "errors");
    if (status != 0)
      throw std::runtime_error(fmt::format("ffmpeg failed: {}", errors.substr(0, errors.find('\n'))));
  }

  fs::path video_;
  double rate_hz_;
  files::AtomicFolder partial_;
  fs::path made_ = partial_.path() / video_.filename();
  TemporaryFolder scratch_;
  std::FILE* ffmpeg_ = nullptr;
};

int video(VideoRequest& request) {
  require_recording(request.result);
  const fs::path file = file_of(request);
  const scenario::Scenario scenario = scenario::read_scenario(request.result / "scenario.yaml").scenario;
  if (!scenario.slam) throw UsageError("{}: no filter ran", request.result.string());
  if (scenario.estimator.source != programs::Source::built_in)
    throw UsageError(
        "{}: was made by the external estimator {}, expected a built-in one; gaitslam view shows this result",
        request.result.string(), scenario.estimator.name);
  const recording::Truth truth = recording::read_truth(request.result / "recording");
  recording::FilterInput input(request.result / "recording", scenario.errors, scenario.seed);
  const recording::RecordingSetup& setup = input.setup();
  tracking::Tracking tracking(scenario, setup.calibration, setup.X_WC_start, setup.camera_rate_hz, setup.rig,
                              setup.joints);
  const view::RobotView robot_view =
      view::robot_from_outside(scenario, request.result / "recording", standard_models());
  Encoder encoder(file, input.setup().camera_rate_hz);
  const OnInterrupt on_interrupt("nothing was written; rerun the command");
  ProgressLine progress("video of " + request.result.string());
  while (auto observation = input.next()) {
    tracking.step(*observation);
    const tracking::TrackedFrame* const frame = tracking.newest();
    if (!frame || !frame->estimate) continue;
    std::vector<cv::Mat> panels{view::draw_view(*observation, frame->report)};
    const auto after = std::ranges::upper_bound(truth.waist, observation->t, {}, &files::TimedPose::t);
    if (robot_view && after != truth.waist.begin())
      panels.push_back(robot_view(observation->t, std::prev(after)->X));
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

void add_export(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "export", "Write a run in the format of another SLAM program or viewer",
                  kExportExamples, export_result);
  add_result(command, request.result);
  command
      .add_option("--format", request.format,
                  fmt::format("one of {}", fmt::join(exports::export_formats(), ", ")))
      ->required();
  add_out(command, request);
  command.add_flag("--undistort", request.undistort, "rectify the images, as tum always does");
}

void add_video(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(
      app, exit_code, "video", "Make a video of the camera images with the matched landmarks, and the robot",
      kVideoExamples, video);
  add_result(command, request.result);
  command.add_option("--out", request.out, "the .mp4 or .webm file to write");
  command.add_flag("--force", request.force, "replace an existing file");
}

}  // namespace cli
