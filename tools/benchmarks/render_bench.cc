// CPU time of one frame of the head camera, all threads counted, along the tangent circle in its room; and
// how well corners are found again in such frames (see corner_error.h).
#include <benchmark/benchmark.h>

#include <string>

#include "sim/world/head_camera.h"
#include "tools/benchmarks/corner_error.h"

namespace {

using namespace sim::world;

constexpr int kHeadings = 24;
constexpr double kTurn = 0.04;  // rad along the circle, between two frames that are compared

void frame(benchmark::State& state, const std::string& room, CameraOptions options) {
  HeadCamera camera(load_model("hrp2", room, GAITSLAM_MODELS), options);
  const Data plant(mj_makeData(&camera.model()));
  int step = 0;
  for (auto _ : state) {
    stand_on_circle(*plant, 2 * CV_PI * (step++ % kHeadings) / kHeadings);
    benchmark::DoNotOptimize(camera.render(*plant).data);
  }
  const CornerError error = corner_error(camera, kHeadings, kTurn);
  state.counters["corners"] = error.corners;
  state.counters["rms_px"] = error.rms_px;
  state.counters["median_px"] = error.median_px;
}

void add(const std::string& name, const std::string& room, const CameraOptions& options) {
  benchmark::RegisterBenchmark(name.c_str(), frame, room, options)
      ->Unit(benchmark::kMillisecond)
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

}  // namespace

int main(int count, char** arguments) {
  add_all("office");
  add_all("hall");
  benchmark::Initialize(&count, arguments);
  if (benchmark::ReportUnrecognizedArguments(count, arguments)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
