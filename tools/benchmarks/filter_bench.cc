// Time of a filter step: prediction, update, search, detection and the whole step on maps of about 50, 100
// and 400 points. Usage: filter_bench [Google Benchmark's flags]
#include <benchmark/benchmark.h>

#include "slam/filter.h"
#include "tests/slam/test_scenes.h"

namespace {

using namespace slam;

const Camera kHeadCamera(synthetic::calibration().camera);

const cv::Mat& picture() {
  static const cv::Mat image = synthetic::Room().render(kHeadCamera, camera_pose(looking_ahead()), 1);
  return image;
}

/// A robot amid `count` points all around it, everything correlated.
struct Scene {
  explicit Scene(std::int64_t count) {
    synthetic::Normal normal(1);
    for (int i = 0; i < static_cast<int>(count); ++i) {
      const double angle = 6.283 * i / static_cast<double>(count);
      RobotVector x = kalman.state().robot();
      x.segment<4>(kOrientation) =
          quaternion_product(quaternion_exp({0, 0, angle}), x.segment<4>(kOrientation));
      const Eigen::Vector2d pixel(160 + 40 * normal(), 120 + 30 * normal()), undisplaced(0, 0);
      Landmark landmark;
      landmark.id = i;
      landmark.X_WC_first = camera_pose(x);
      landmark.patch = cut_patch(picture(), {100 + i % 100, 100});
      landmark.at =
          kalman.append(initialize_inverse_depth(x, *kHeadCamera.unproject(pixel), 1, undisplaced, {}));
      const Parameters y = kalman.state().storage_x.segment<6>(landmark.at);
      kalman.replace(landmark.at, 6, position(InverseDepth{}, y), position_jacobian(InverseDepth{}, y));
      landmark.kind = Point{};
      landmarks.push_back(landmark);
    }
  }

  Kalman kalman{{looking_ahead(), 1e-4 * RobotMatrix::Identity()}, true};
  std::vector<Landmark> landmarks;
};

void Predict(benchmark::State& state) {
  Scene scene(state.range(0));
  const Prediction prediction =
      predict_motion(scene.kalman.state().robot(), 1.0 / 30, std::nullopt, Options{});
  for (auto _ : state) scene.kalman.predict(prediction.x, prediction.F, 1e-9 * prediction.Q);
}
BENCHMARK(Predict)->Arg(50)->Arg(100)->Arg(400);

/// With two rows of each of 12 matches.
void Update(benchmark::State& state) {
  Scene scene(state.range(0));
  const auto view = predict_view(scene.kalman, scene.landmarks, kHeadCamera, 1);
  std::vector<Measurement> measurements;
  for (std::size_t i = 0; i < 12; ++i) measurements.push_back(view[i % view.size()].measurement);
  StackedMeasurement stacked;
  for (auto _ : state) {
    stack(scene.kalman.state(), measurements, stacked);
    benchmark::DoNotOptimize(scene.kalman.update(stacked));
  }
}
BENCHMARK(Update)->Arg(50)->Arg(100)->Arg(400);

/// One template in the 3-sigma ellipse of sigma px.
void Search(benchmark::State& state) {
  const Template patch = template_at(picture(), {150, 110});
  const double sigma = static_cast<double>(state.range(0));
  for (auto _ : state)
    benchmark::DoNotOptimize(
        search_ellipse(picture(), patch, {152, 111}, sigma * sigma * Eigen::Matrix2d::Identity(), 3));
}
BENCHMARK(Search)->Arg(1)->Arg(2)->Arg(4)->Arg(8);

/// The strongest corner of a quarter by a quarter of the image.
void Detect(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(strongest_corner(picture(), {100, 90, 80, 60}, 20000));
}
BENCHMARK(Detect);

/// Two laps of a circle of 0.75 m in a synthetic room, 10 s each: the first makes the map, the second is
/// timed.
constexpr std::size_t kFrames = 600;
const std::vector<Observation>& laps(const synthetic::Walk& walk) {
  static const std::vector<Observation> observations = [&] {
    const synthetic::Recording recording(walk, synthetic::render(synthetic::Room(), walk));
    std::vector<Observation> all;
    for (int k = 0; k < static_cast<int>(kFrames); ++k) all.push_back(recording.observation(k));
    return all;
  }();
  return observations;
}

/// All that a frame takes, gates and report included, when `in view` landmarks are kept in view and 12 of
/// them are measured.
void Step(benchmark::State& state) {
  synthetic::Walk walk;
  walk.turns = 2;
  walk.duration_s = 20.5;
  Options options;
  options.vision.visible_landmarks = static_cast<int>(state.range(0));
  options.depth.linearity = 1;
  options.vision.corner_threshold = 5000;
  Filter filter(options, synthetic::calibration(), walk.X_WC(0), 1);
  std::size_t k = 0;
  while (k < kFrames / 2) filter.step(laps(walk)[k++]);
  double landmarks = 0, accepted = 0;
  for (auto _ : state) {
    const FrameReport& report = filter.step(laps(walk)[k++]);
    landmarks += report.landmarks, accepted += report.accepted;
    if (report.health != Health::ok) return state.SkipWithError(report.cause->c_str());
  }
  state.counters["landmarks"] = landmarks / (kFrames / 2.0);
  state.counters["accepted"] = accepted / (kFrames / 2.0);
}
BENCHMARK(Step)->Arg(9)->Arg(18)->Arg(140)->Iterations(kFrames / 2)->Unit(benchmark::kMicrosecond);

}  // namespace

int main(int argc, char** argv) {
  Eigen::setCpuCacheSizes(32 << 10, 256 << 10,
                          8 << 20);  // as the program does: results must not depend on them
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
