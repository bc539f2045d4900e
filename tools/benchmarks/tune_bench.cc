// What a trial costs: of the filter from a recording in memory, in one and two threads, and from the disk.
#include <fmt/core.h>

#include <Eigen/Core>
#include <chrono>
#include <cstdio>
#include <opencv2/core.hpp>
#include <thread>

#include "sim/replay/replay.h"
#include "sim/result/timing.h"
#include "sim/tune/trial.h"

namespace {

namespace fs = std::filesystem;
using namespace sim;

double wall_s() {
  return 1e-9 * static_cast<double>(std::chrono::steady_clock::now().time_since_epoch().count());
}

// CPU and wall seconds that `work` takes.
struct Cost {
  double cpu_s, wall_s;
};
template <typename Work>
Cost cost(const Work& work) {
  const double cpu = result::process_cpu_ms(), wall = wall_s();
  work();
  return {1e-3 * (result::process_cpu_ms() - cpu), wall_s() - wall};
}

void print(const char* what, Cost c, double simulated_s) {
  fmt::print("{:<42} {:7.3f} s CPU {:7.3f} s wall {:7.1f} x real time per core\n", what, c.cpu_s, c.wall_s,
             simulated_s / c.cpu_s);
}

double resident_mb() {
  long pages = 0, resident = 0;
  std::FILE* file = std::fopen("/proc/self/statm", "r");
  if (file == nullptr || std::fscanf(file, "%ld %ld", &pages, &resident) != 2) resident = 0;
  if (file != nullptr) std::fclose(file);
  return 4096e-6 * static_cast<double>(resident);
}

void measure(const fs::path& folder, int trials) {
  const scenario::ReadScenario scenario = scenario::read_scenario(folder / "scenario.yaml");
  tune::Recording ideal, seen;
  const Cost loading = cost([&] { ideal = tune::load(folder); });
  const double walked_s = slam::seconds(ideal.observations.back().t);
  print("recording read, images decoded", loading, walked_s);
  print("trial, sensor errors drawn for it", cost([&] { tune::run_trial(ideal, scenario); }), walked_s);
  ideal = {};
  seen = tune::load(folder, scenario.scenario);
  fmt::print("memory with one recording of {:.1f} MB of images: {:.1f} MB\n",
             1e-6 * static_cast<double>(seen.bytes()), resident_mb());
  const auto some = [&](int n) {
    for (int i = 0; i < n; ++i) tune::run_trial(seen, scenario);
  };
  some(1);
  const Cost one = cost([&] { some(trials); });
  print("trials, one thread", one, walked_s * trials);
  const Cost two = cost([&] {
    std::jthread a([&] { some(trials); });
    std::jthread b([&] { some(trials); });
  });
  print("twice as many trials, two threads", two, 2 * walked_s * trials);
  fmt::print("two threads do {:.2f} times as many trials a second; CPU per trial grows by {:.1f} %\n",
             2 * one.wall_s / two.wall_s, 100 * (two.cpu_s / 2 / one.cpu_s - 1));
  fmt::print("memory during trials: {:.1f} MB\n", resident_mb());
  const fs::path out = fs::temp_directory_path() / "gaitslam tune_bench";
  print("replay from the disk, result written", cost([&] {
          replay::replay(scenario, folder / "recording", {{scenario::Ending::completed}},
                         {out, files::Existing::replace, {}, "1", "bench", {}}, [](double) {});
        }),
        walked_s);
  fs::remove_all(out);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: tune_bench RESULT_FOLDER [TRIALS]\n");
    return 2;
  }
  Eigen::setCpuCacheSizes(32 << 10, 256 << 10, 8 << 20);
  cv::setNumThreads(1);
  measure(argv[1], argc > 2 ? std::atoi(argv[2]) : 4);
}
