// Time of a filter step: prediction, update, search, detection and the whole step on maps of about 50, 100
// and 400 points, each beside its bound from the core's arithmetic or memory bandwidth. Usage: filter_bench
// [Google Benchmark's flags]
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <algorithm>
#include <ctime>
#include <map>

#include "slam/filter.h"
#include "slam/motion_model.h"
#include "slam/vision/active_search.h"
#include "slam/vision/corner_detector.h"
#include "slam/vision/patch.h"
#include "tests/slam/synthetic_room.h"

namespace {

using namespace slam;

constexpr int kMatches = 12;

/// Best of several: what one core can do.
template <typename Work>
double fastest_s(const Work& work) {
  double best = 1e9;
  for (int i = 0; i < 12; ++i) {
    const std::clock_t begin = std::clock();  // CPU time: other programs do not count
    for (int k = 0; k < 20; ++k) work();
    best = std::min(best, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / 20);
  }
  return best;
}

/// Double precision multiplications and additions a second, by Eigen's product of two large matrices.
double peak_flops() {
  static const double peak = [] {
    constexpr int n = 480;
    const Eigen::MatrixXd A = Eigen::MatrixXd::Random(n, n), B = Eigen::MatrixXd::Random(n, n);
    Eigen::MatrixXd C(n, n);
    return 2.0 * n * n * n / fastest_s([&] {
             C.noalias() = A * B;
             benchmark::DoNotOptimize(C.data());
           });
  }();
  return peak;
}

/// Bytes a second, reading and writing counted, when an array of that size is changed in place.
double bandwidth(double bytes) {
  static std::map<double, double> known;
  if (const auto found = known.find(bytes); found != known.end()) return found->second;
  Eigen::ArrayXd a = Eigen::ArrayXd::Zero(static_cast<Eigen::Index>(bytes / 8));
  return known[bytes] = 2 * bytes / fastest_s([&] {
                          a += 1;
                          benchmark::DoNotOptimize(a.data());
                        });
}

/// Counters: the larger of the two bounds in µs, and what part of the time it explains.
void bound(benchmark::State& state, double flops, double bytes_touched) {
  const double arithmetic = flops / peak_flops();
  const double memory = bytes_touched > 0 ? 2 * bytes_touched / bandwidth(bytes_touched) : 0;
  const double longest = std::max(arithmetic, memory);
  state.counters["flop_bound_us"] = 1e6 * arithmetic;
  state.counters["memory_bound_us"] = 1e6 * memory;
  state.counters["of_bound"] =
      benchmark::Counter(longest * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

Eigen::Isometry3d start_pose() {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  X.translation().z() = 1.4;
  return X;
}

/// A robot amid `count` points all around it, everything correlated.
struct Scene {
  explicit Scene(int count) {
    synthetic::Normal normal(1);
    const Camera camera(calibration.camera);
    const cv::Mat image = picture();
    for (int i = 0; i < count; ++i) {
      const double angle = 6.283 * i / count;
      Eigen::Isometry3d X = start_pose();
      X.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) * X.linear();
      RobotVector x = kalman.state().storage_x.head<kRobot>();
      const Eigen::Quaterniond q(X.linear());
      x.segment<4>(kOrientation) << q.w(), q.x(), q.y(), q.z();
      const Eigen::Vector2d pixel(160 + 40 * normal(), 120 + 30 * normal());
      Landmark landmark;
      landmark.id = i;
      landmark.X_WC_first = X;
      landmark.patch = cut_patch(image, {100 + i % 100, 100});
      const Eigen::Vector2d undisplaced = Eigen::Vector2d::Zero();
      landmark.at = kalman.append(
          initialize_inverse_depth(x, *camera.unproject(pixel), 1, undisplaced, Options{}.depth));
      const Vector6d y = kalman.state().storage_x.segment<6>(landmark.at);
      kalman.replace(landmark.at, 6, inverse_depth_position(y), inverse_depth_position_jacobian(y));
      landmark.kind = Point{};
      landmarks.push_back(landmark);
    }
  }
  static cv::Mat picture() {
    const synthetic::Room room;
    return room.render(Camera(calibration.camera), start_pose(), 1);
  }
  static Kalman standing() {
    RobotVector x = RobotVector::Zero();
    const Eigen::Quaterniond q(start_pose().linear());
    x.segment<3>(kPosition) = start_pose().translation();
    x.segment<4>(kOrientation) << q.w(), q.x(), q.y(), q.z();
    return Kalman({x, 1e-4 * RobotMatrix::Identity()}, true);
  }

  inline static const Calibration calibration = synthetic::calibration();
  Kalman kalman = standing();
  std::vector<Landmark> landmarks;

  std::vector<Measurement> matches(int wanted) const {
    const auto view = predict_view(kalman, landmarks, Camera(calibration.camera), 1);
    std::vector<Measurement> found;
    for (int i = 0; i < wanted; ++i)
      found.push_back(view[static_cast<std::size_t>(i) % view.size()].measurement);
    return found;
  }
  double n() const { return kalman.state().size; }
};

void Predict(benchmark::State& state) {
  Scene scene(static_cast<int>(state.range(0)));
  const RobotVector x = scene.kalman.state().storage_x.head<kRobot>();
  const Prediction prediction = predict_motion(x, 1.0 / 30, std::nullopt, Options{});
  for (auto _ : state) scene.kalman.predict(prediction.x, prediction.F, 1e-9 * prediction.Q);
  bound(state, 2.0 * kRobot * kRobot * scene.n(), 8 * kRobot * scene.n());
}
BENCHMARK(Predict)->Arg(50)->Arg(100)->Arg(400);

/// Rows: 7 of gyro, velocity and height, or two of each match.
void Update(benchmark::State& state) {
  Scene scene(static_cast<int>(state.range(0)));
  const auto measurements = scene.matches(kMatches);
  StackedMeasurement stacked;
  for (auto _ : state) {
    stack(scene.kalman.state(), measurements, stacked);
    benchmark::DoNotOptimize(scene.kalman.update(stacked));
  }
  const double n = scene.n(), m = 2 * kMatches;
  bound(state, n * n * m + 2 * n * kRobot * m + n * m * m, 8 * n * n / 2);
}
BENCHMARK(Update)->Arg(50)->Arg(100)->Arg(400);

void PredictView(benchmark::State& state) {
  const Scene scene(static_cast<int>(state.range(0)));
  const Camera camera(Scene::calibration.camera);
  std::size_t in_view = 0;
  for (auto _ : state) in_view = predict_view(scene.kalman, scene.landmarks, camera, 1).size();
  state.counters["in_view"] = static_cast<double>(in_view);
}
BENCHMARK(PredictView)->Arg(50)->Arg(100)->Arg(400);

/// One template in the 3-sigma ellipse of sigma px; bound: the 121 products at each place.
void Search(benchmark::State& state) {
  const cv::Mat image = Scene::picture();
  const auto patch = warp(cut_patch(image, {150, 110}), Eigen::Matrix2d::Identity());
  const double sigma = static_cast<double>(state.range(0));
  for (auto _ : state)
    benchmark::DoNotOptimize(
        search_ellipse(image, *patch, {152, 111}, sigma * sigma * Eigen::Matrix2d::Identity(), 3));
  const double places = 3.1416 * 9 * sigma * sigma;
  bound(state, 121 * places, 0);  // floats: twice as many at once as doubles
  state.counters["ns_per_place"] =
      benchmark::Counter(1e-9 * places * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(Search)->Arg(1)->Arg(2)->Arg(4)->Arg(8);

void WarpAndRefine(benchmark::State& state) {
  const cv::Mat image = Scene::picture();
  const SourcePatch source = cut_patch(image, {150, 110});
  for (auto _ : state) {
    const auto patch = warp(source, Eigen::Matrix2d::Identity());
    benchmark::DoNotOptimize(refine(image, *patch, {150, 110}));
  }
}
BENCHMARK(WarpAndRefine);

/// The strongest corner of a quarter by a quarter of the image.
void Detect(benchmark::State& state) {
  const cv::Mat image = Scene::picture();
  for (auto _ : state) benchmark::DoNotOptimize(strongest_corner(image, {100, 90, 80, 60}, 20000));
}
BENCHMARK(Detect);

/// Two laps of a circle of 0.75 m in a synthetic room, 10 s each: the first makes the map, the second is
/// timed.
struct Laps {
  static constexpr int kFrames = 600;
  Laps() {
    walk.turns = 2;
    walk.duration_s = 20.5;
    const synthetic::Room room;
    synthetic::Recording recording(walk, synthetic::render(room, walk));
    for (int k = 0; k < kFrames; ++k) observations.push_back(recording.observation(k));
  }
  synthetic::Walk walk;
  std::vector<Observation> observations;
};

/// All that a frame takes, gates and report included, when `in view` landmarks are kept in view and 12 of
/// them are measured.
void Step(benchmark::State& state) {
  static const Laps laps;
  Options options;
  options.vision.visible_landmarks = static_cast<int>(state.range(0));
  options.depth.linearity = 1;
  options.vision.corner_threshold = 5000;
  Filter filter(options, synthetic::calibration(), laps.walk.X_WC(0), 1);
  int k = 0;
  while (k < Laps::kFrames / 2) filter.step(laps.observations[static_cast<std::size_t>(k++)]);
  double landmarks = 0, accepted = 0, frames = 0;
  for (auto _ : state) {
    const FrameReport& report = filter.step(laps.observations[static_cast<std::size_t>(k++)]);
    landmarks += report.landmarks, accepted += report.accepted, ++frames;
    if (report.health != Health::ok) return state.SkipWithError(report.cause.c_str());
  }
  const auto map = filter.map();
  const auto points = static_cast<double>(
      std::count_if(map.begin(), map.end(), [](const MapPoint& p) { return p.kind == "point"; }));
  state.counters["landmarks"] = landmarks / frames;
  state.counters["points"] = points;
  state.counters["accepted"] = accepted / frames;
  const double n = kRobot + 6 * static_cast<double>(map.size()) - 3 * points, m = 2 * accepted / frames + 7;
  bound(state, n * n * m + 2 * n * kRobot * (kRobot + m), 8 * n * n / 2);
}
BENCHMARK(Step)->Arg(9)->Arg(18)->Arg(140)->Iterations(Laps::kFrames / 2)->Unit(benchmark::kMicrosecond);

}  // namespace

int main(int argc, char** argv) {
  Eigen::setCpuCacheSizes(32 << 10, 256 << 10,
                          8 << 20);  // as the program does: results must not depend on them
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
