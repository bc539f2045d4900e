// Measures the filter's CPU time per frame on a recorded walk, split into the two parts that a run attributes
// to the filter: sensor errors and filter steps. Steps are measured with warm caches and after other work has
// emptied the caches. Usage: filter_bench RESULT, where RESULT is the folder of a run
#include <fmt/format.h>

#include <Eigen/Core>
#include <cstdlib>
#include <numeric>

#include "sim/recording/recording.h"
#include "sim/result/result.h"
#include "sim/scenario/scenario.h"
#include "sim/score/statistics.h"
#include "slam/filter.h"

namespace {

namespace fs = std::filesystem;
using Work = std::function<void(const slam::Observation&)>;

/// Prints the CPU time of `work` per observation; `before` is called before each one and is not counted.
void measure(
    const char* name, const std::vector<slam::Observation>& walk, const Work& work,
    const std::function<void()>& before = [] {}) {
  std::vector<double> ms;
  for (const slam::Observation& observation : walk) {
    before();
    const sim::result::StageClock clock(ms.emplace_back(0));
    work(observation);
  }
  fmt::print("{:<24}{:8.3f} ms (median; p99 {:.3f}, mean {:.3f})\n", name, sim::score::quantile(ms, 0.5),
             sim::score::quantile(ms, 0.99), sim::score::mean(ms));
}

/// Replaces all cached data, as physics and rendering do between two frames of a run.
void empty_caches() {
  static std::vector<std::uint64_t> other(std::size_t{64} << 17);  // 64 MiB
  for (std::size_t i = 0; i < other.size(); i += 8) ++other[i];
}

void bench(const fs::path& result) {
  const sim::scenario::Scenario scenario = sim::scenario::read_scenario(result / "scenario.yaml").scenario;
  sim::recording::RecordingReader reader(result / "recording");
  const sim::recording::RecordingSetup& setup = reader.setup();
  std::vector<slam::Observation> ideal, arrived;
  while (auto observation = reader.next()) ideal.push_back(std::move(*observation));
  sim::sensor_errors::SensorErrors errors(scenario.errors, scenario.seed, setup.rig);
  measure("sensor errors", ideal, [&](const slam::Observation& observation) {
    std::ranges::move(errors.process(observation), std::back_inserter(arrived));
  });
  const auto steps = [&](const char* name, auto... before) {
    slam::Filter filter(*scenario.slam, setup.calibration, setup.X_WC_start, scenario.seed);
    measure(
        name, arrived, [&](const slam::Observation& observation) { filter.step(observation); }, before...);
  };
  steps("filter, warm caches");
  steps("filter, emptied caches", empty_caches);
}

}  // namespace

int main(int argc, char** argv) {
  Eigen::setCpuCacheSizes(32 << 10, 256 << 10,
                          8 << 20);  // as in the program: results must not depend on the machine's caches
  if (argc != 2) return fmt::print(stderr, "usage: filter_bench RESULT\n"), 2;
  try {
    bench(argv[1]);
  } catch (const std::exception& problem) {
    return fmt::print(stderr, "filter_bench: {}\n", problem.what()), 2;
  }
  return 0;
}
