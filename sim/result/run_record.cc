#include "sim/result/run_record.h"

#include <fmt/format.h>

#include <algorithm>

namespace sim::result {
namespace {

constexpr std::size_t kFewFrames = 10;  // fewer do not show that a sensor is unused

bool is_enabled(const scenario::Scenario& scenario, slam::SensorIndex sensor) {
  using enum slam::SensorIndex;
  const slam::Options& options = *scenario.slam;
  switch (sensor) {
    case vision:
      return uses_images(scenario);
    case gyro:
      return options.gyro.enabled;
    case plan_velocity:
      return options.plan_velocity.enabled;
    case height:
      return options.height.enabled;
    case accelerometer:
      return options.accelerometer.enabled;
  }
  return false;
}

// The first enabled sensor of the filter that was used in no frame.
std::optional<scenario::Ended> unused_sensor(const RunRecord& record) {
  const auto& frames = record.tracked->frames;
  if (!uses_filter(record.scenario.scenario) || frames.size() < kFewFrames) return std::nullopt;
  for (std::size_t i = 0; i < slam::kSensorNames.size(); ++i) {
    const auto has = [i](const tracking::TrackedFrame& frame) {
      return frame.report.use[i] != slam::SensorUse::none;
    };
    const auto uses = [i](const tracking::TrackedFrame& frame) {
      return frame.report.use[i] == slam::SensorUse::accepted;
    };
    if (!is_enabled(record.scenario.scenario, static_cast<slam::SensorIndex>(i)) ||
        std::ranges::any_of(frames, uses))
      continue;
    const auto readings = std::ranges::count_if(frames, has);
    return scenario::Ended{
        scenario::Ending::sensor_unused,
        readings == 0 ? fmt::format("the filter had no readings of {}; slam.{}.enabled: false expects none",
                                    slam::kSensorNames[i], slam::kSensorNames[i])
                      : fmt::format("the filter accepted {} in none of the {} frames with readings",
                                    slam::kSensorNames[i], readings)};
  }
  return std::nullopt;
}

}  // namespace

bool uses_filter(const scenario::Scenario& scenario) {
  const estimators::EstimatorChoice& estimator = scenario.estimator;
  return scenario.slam && estimator.source == estimators::Source::built_in &&
         (estimator.name == "filter" || estimator.name == "odometry");
}

bool uses_images(const scenario::Scenario& scenario) {
  return uses_filter(scenario) && scenario.estimator.name == "filter" && scenario.slam->vision.enabled;
}

scenario::Ended ending_of(const RunRecord& record) {
  using enum scenario::Ending;
  auto failure = record.tracked ? record.tracked->failure() : std::nullopt;
  if (!failure && record.tracked) failure = unused_sensor(record);
  // A robot stops if the estimator that steers it fails.
  const bool explains_stop = record.walk.ending == stopped && failure && failure->ending == estimator_failed;
  return failure && (record.walk.ending == completed || explains_stop) ? *failure : record.walk;
}

}  // namespace sim::result
