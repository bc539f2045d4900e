// CPU time of one frame of the head camera, all threads counted, along the tangent circle in its room; and
// how well corners are found again in such frames (see corner_error.h). `least_ms` is the mean over all
// headings of the least time each took: what a frame costs when nothing else disturbs it; positions_ms,
// drawing_ms and lens_ms are the parts of it.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <numeric>
#include <string>

#include "sim/camera/head_camera.h"
#include "tools/benchmarks/corner_error.h"
#include "tools/benchmarks/cpu_time.h"

namespace {

using namespace sim::camera;
using namespace sim::physics;

constexpr int kHeadings = 24, kRounds = 6;
constexpr int kPartRounds = 3;
constexpr double kTurn = 0.04;  // rad along the circle, between two frames that are compared

// CPU time of the parts of a frame, mean over all headings: the robot's positions, OpenGL, the lens.
void measure_parts(benchmark::State& state, const std::string& room, const CameraOptions& options) {
  const Model model = load_model("hrp2", room, GAITSLAM_MODELS);
  const Data data(mj_makeData(model.get()));
  const LensWarp lens(camera_model(options), source_density(options));
  Scene scene(*model, lens.views(), options.samples, 1, Channels::grey);
  std::array<double, 3> ms{};
  for (int step = 0; step <= kPartRounds * kHeadings; ++step) {
    if (step == 1) ms.fill(0);  // the first frame compiles shaders
    stand_on_circle(*data, 2 * CV_PI * step / kHeadings);
    std::array<double, 4> at{cpu_ms()};
    mj_kinematics(model.get(), data.get());
    mj_camlight(model.get(), data.get());
    at[1] = cpu_ms();
    const cv::Mat views = scene.draw(*data, camera_pose(*model, *data, "head_camera"));
    at[2] = cpu_ms();
    benchmark::DoNotOptimize(lens.warp(views).data);
    at[3] = cpu_ms();
    for (std::size_t i = 0; i < ms.size(); ++i) ms[i] += (at[i + 1] - at[i]) / (kPartRounds * kHeadings);
  }
  state.counters["positions_ms"] = ms[0], state.counters["drawing_ms"] = ms[1],
  state.counters["lens_ms"] = ms[2];
}

void frame(benchmark::State& state, const std::string& room, CameraOptions options,
           WorldOptions::LightsOff lights_off) {
  HeadCamera camera(load_model("hrp2", room, GAITSLAM_MODELS), options);
  const Data plant(mj_makeData(&camera.model()));
  std::array<double, kHeadings> least_ms;
  least_ms.fill(1e9);
  int step = 0;
  for (auto _ : state) {
    const int heading = step++ % kHeadings;
    const double yaw = 2 * CV_PI * heading / kHeadings;
    RecentMotion motion(std::chrono::seconds(1));
    for (const int ms : {0, 100}) {
      stand_on_circle(*plant, yaw + 1e-3 * ms);
      motion.add(std::chrono::milliseconds(ms), camera.model(), *plant);
    }
    const double began_ms = cpu_ms();
    benchmark::DoNotOptimize(camera.render(motion, std::chrono::milliseconds(50), lights_off).data);
    least_ms[heading] = std::min(least_ms[heading], cpu_ms() - began_ms);
  }
  state.counters["least_ms"] = std::accumulate(least_ms.begin(), least_ms.end(), 0.0) / kHeadings;
  if (options.exposure_s > 0 || options.readout_s > 0 || lights_off.duration_s > 0) return;
  measure_parts(state, room, options);
  const CornerError error = corner_error(camera, kHeadings, kTurn);
  state.counters["corners"] = error.corners;
  state.counters["rms_px"] = error.rms_px;
  state.counters["median_px"] = error.median_px;
}

void add(const std::string& name, const std::string& room, const CameraOptions& options,
         const WorldOptions::LightsOff& lights_off = {}) {
  benchmark::RegisterBenchmark(name.c_str(), frame, room, options, lights_off)
      ->Unit(benchmark::kMillisecond)
      ->Iterations(kRounds * kHeadings)
      ->MeasureProcessCPUTime();
}

void add_all(const std::string& room) {
  for (const int width : {320, 640})
    for (const Lens lens : {Lens::wide, Lens::pinhole})
      for (const int samples : {0, 4}) {
        CameraOptions options;
        options.width_px = width, options.height_px = width * 3 / 4;
        options.lens = lens, options.samples = samples;
        add(room + "/" + std::to_string(width) + (lens == Lens::wide ? "/wide" : "/pinhole") + "/samples_" +
                std::to_string(samples),
            room, options);
      }
}

void add_effects(int width) {
  CameraOptions sharp, blurred, rolling;
  sharp.width_px = blurred.width_px = rolling.width_px = width;
  sharp.height_px = blurred.height_px = rolling.height_px = width * 3 / 4;
  blurred.exposure_s = 0.01, rolling.readout_s = 0.02;
  const std::string size = "office/" + std::to_string(width) + "/wide";
  add(size + "/motion_blur", "office", blurred);
  add(size + "/rolling_shutter", "office", rolling);
  add(size + "/lights_off", "office", sharp, {0, 1, 0.15});
}

}  // namespace

int main(int count, char** arguments) {
  add_all("office");
  add_all("hall");
  for (const int width : {320, 640}) add_effects(width);
  benchmark::Initialize(&count, arguments);
  if (benchmark::ReportUnrecognizedArguments(count, arguments)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
