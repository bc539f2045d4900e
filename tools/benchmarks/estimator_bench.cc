// Time from an observation to the answer of an estimator that computes almost nothing: built in, and as
// external programs.
//   estimator_bench PROGRAM...
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <span>
#include <string>
#include <vector>

#include "sim/estimators/estimator.h"

namespace {

namespace estimators = sim::estimators;

/// A frame of the default camera with the inertial readings since the one before.
slam::Observation observation(int frame) {
  slam::Observation o;
  o.t = std::chrono::milliseconds(33 * frame);
  o.image = cv::Mat(240, 320, CV_8UC1, cv::Scalar(frame % 256));
  for (int k = 0; k < 7; ++k) {
    const slam::Stamp begin = o.t - std::chrono::milliseconds(33) + k * std::chrono::microseconds(4714);
    o.gyro.push_back({begin, begin + std::chrono::microseconds(4714), {0.1, 0.2, 0.3}});
    o.accelerometer.push_back({begin, begin + std::chrono::microseconds(4714), {0, 0, 9.81}});
  }
  o.plan.emplace();
  return o;
}

/// Wall times of the frames, ms, in order of size.
std::vector<double> times_ms(const estimators::EstimatorChoice& choice) {
  const auto estimator = estimators::make_estimator(choice, {});
  std::vector<double> times;
  for (int frame = 0; frame < 3000; ++frame) {
    const slam::Observation o = observation(frame);
    const auto begin = std::chrono::steady_clock::now();
    estimator->step(o);
    times.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
  }
  estimator->finish();
  std::sort(times.begin(), times.end());
  return times;
}

void print(const std::string& name, const std::vector<double>& times) {
  fmt::print("{:<60} {:.4f} ms a frame (median), {:.4f} ms (95 %)\n", name, times[times.size() / 2],
             times[times.size() * 95 / 100]);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fputs("usage: estimator_bench PROGRAM...\n", stderr);
    return 2;
  }
  try {
    print("plan_alone, built in", times_ms({.name = "plan_alone", .words = {}, .options = {}}));
    for (const std::string program : std::span(argv + 1, static_cast<std::size_t>(argc - 1)))
      print(program, times_ms({estimators::Source::program, "external", {program}, {}, 60, 10}));
  } catch (const std::exception& failure) {
    fmt::print(stderr, "{}\n", failure.what());
    return 1;
  }
  return 0;
}
