#include "sim/scenario/scenario.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <variant>

#include "sim/scenario/keys.h"
#include "walking/timeline.h"

namespace sim::scenario {
namespace {

/// Returns the planned walk, or nullopt if it cannot be carried out: that is reported when it is planned.
/// Throws ConfigError at the command that makes the walk too long.
std::optional<walking::Timeline> planned(const ReadScenario& read, const Yaml& root) {
  try {
    return walking::Timeline(read.scenario.walk, {}, Eigen::Vector2d::Zero());
  } catch (const walking::TooLong& e) {
    const auto command = static_cast<std::size_t>(e.command);
    Yaml at = root;
    if (command < read.command_origins.size()) at.origin = read.command_origins[command];
    fail(at, "", e.what());
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

/// Returns why a fault, push or darkness of this time never happens, or "". end_s: of the walk.
std::string never_happens(double from_s, double duration_s, double end_s) {
  if (duration_s == 0) return "never happens: its duration_s is 0";
  if (from_s >= end_s)
    return fmt::format("never happens: it begins at {} s, the walk ends at {:.1f} s", from_s, end_s);
  return "";
}

std::string never_happens(const sensor_errors::Fault& any, double end_s) {
  return std::visit(
      [&](const auto& fault) -> std::string {
        if constexpr (requires { fault.fraction; })
          if (fault.fraction == 0) return "never happens: its fraction is 0";
        if constexpr (requires { fault.factor; })
          if (fault.factor == 1) return "changes nothing: its factor is 1";
        if constexpr (requires { fault.size_rad_s; })
          if (fault.size_rad_s == 0) return "changes nothing: its size_rad_s is 0";
        if constexpr (requires { fault.size_m_s2; })
          if (fault.size_m_s2 == 0) return "changes nothing: its size_m_s2 is 0";
        if constexpr (requires { fault.yaw_rad; })
          if (fault.x_m == 0 && fault.y_m == 0 && fault.yaw_rad == 0)
            return "changes nothing: its x_m, y_m and yaw_deg are 0";
        return never_happens(fault.from_s, fault.duration_s, end_s);
      },
      any);
}

constexpr const char* kNoCamera = "never happens: this scenario has no section 'camera'";

/// Returns why the estimator does not notice the fault of a sensor, or "". External programs may use each.
std::string unnoticed(const sensor_errors::Fault& fault, std::string_view kind, const Scenario& scenario) {
  if (sensor_errors::is_of_steering(fault)) return "";
  if (!scenario.camera) return kNoCamera;
  if (!scenario.slam) return "changes nothing: this scenario has no section 'slam'";
  const bool of_arrival =
      kind == sensor_errors::FramesDoubled::kName || kind == sensor_errors::FramesReordered::kName;
  if (of_arrival || scenario.estimator.source != estimators::Source::built_in) return "";
  const slam::Options& filter = *scenario.slam;
  const std::string& name = scenario.estimator.name;
  const bool plan_alone = name == "plan_alone";
  struct Use {
    std::string_view faults;
    bool by_estimator, enabled;
    const char* disabled;
  };
  for (const Use& use :
       {Use{"frames_", name == "filter", filter.vision.enabled, "slam.vision.enabled is false"},
        Use{"gyro_", !plan_alone, filter.gyro.enabled, "slam.gyro.enabled is false"},
        Use{"accelerometer_", !plan_alone, filter.accelerometer.enabled,
            "slam.accelerometer.enabled is false"},
        Use{"plan_", true, plan_alone || filter.plan_velocity.enabled || filter.height.enabled,
            "slam.plan_velocity.enabled and slam.height.enabled are false"}}) {
    if (!kind.starts_with(use.faults)) continue;
    if (!use.by_estimator) return fmt::format("changes nothing: estimator {} does not use that sensor", name);
    if (!use.enabled) return std::string("changes nothing: ") + use.disabled;
  }
  return "";
}

/// Throws ConfigError for a fault, push or darkness that never happens or that nothing notices.
void check_happens(const ReadScenario& read, const Yaml& root, double end_s) {
  const Scenario& scenario = read.scenario;
  Yaml at = root;
  const auto require = [&](const std::string& key, const std::string& problem) {
    if (!problem.empty()) fail(at, key, problem);
  };
  if (const auto place = read.places.find("errors.faults"); place != read.places.end())
    at.origin = place->second;
  for (const sensor_errors::Fault& fault : scenario.errors.faults) {
    const std::string kind = std::visit([](const auto& f) { return f.kName; }, fault);
    require("errors.faults: " + kind, never_happens(fault, end_s));
    require("errors.faults: " + kind, unnoticed(fault, kind, scenario));
  }
  at = root;
  for (const physics::Push& push : scenario.world.pushes) {
    require("world.pushes: push", never_happens(push.time_s, push.duration_s, end_s));
    if (push.impulse_ns == 0) fail(at, "world.pushes: push", "never happens: its impulse_ns is 0");
  }
  const physics::WorldOptions::LightsOff& dark = scenario.world.lights_off;
  if (dark.from_s == 0 && dark.duration_s == 0) return;
  require("world.lights_off", never_happens(dark.from_s, dark.duration_s, end_s));
  if (!scenario.camera) fail(at, "world.lights_off", kNoCamera);
  if (dark.left_fraction == 1) fail(at, "world.lights_off", "changes nothing: its left_fraction is 1");
}

/// Throws ConfigError if landmarks are to start with a depth that the rig does not measure.
void check_measured_depth(const ReadScenario& read, Yaml at) {
  const Scenario& scenario = read.scenario;
  const auto measures_head_depth = [](const rig::Item& item) {
    const auto* depth = std::get_if<rig::DepthCamera>(&item);
    return depth && depth->aligned_with == "cam0";
  };
  if (!scenario.slam || scenario.slam->depth.first_sight != slam::FirstSight::measured_depth ||
      std::ranges::any_of(scenario.rig, measures_head_depth))
    return;
  const std::string key = "slam.depth.first_sight";
  if (const auto place = read.places.find(key); place != read.places.end()) at.origin = place->second;
  fail(at, key,
       "is measured_depth, expected a depth camera in the rig that is aligned with cam0, as in rig: d435i");
}

/// Throws ConfigError at a key of estimator.time that contradicts another one.
void check_time(const ReadScenario& read, const Yaml& root) {
  const EstimatorTime& time = read.scenario.estimator_time;
  const auto require = [&](bool holds, const char* name, const std::string& problem) {
    if (holds) return;
    const std::string key = std::string("estimator.time.") + name;
    Yaml at = root;
    if (const auto place = read.places.find(key); place != read.places.end()) at.origin = place->second;
    fail(at, key, problem);
  };
  const std::string_view model = kTimeModels[static_cast<std::size_t>(time.model)];
  const bool none = time.model == TimeModel::none, fixed = time.model == TimeModel::fixed;
  require(fixed || time.frame_ms == 0, "frame_ms",
          fmt::format("is {}, but estimator.time.model is {}; expected 0, or model: fixed", time.frame_ms,
                      model));
  require(!fixed || read.origin.contains("estimator.time.frame_ms"), "model",
          "is fixed, expected estimator.time.frame_ms with it");
  require(!none || time.queue == 0, "queue", "is 1, but estimator.time.model is none and no frame waits");
  require(!none || time.on_busy == OnBusy::drop, "on_busy",
          "is wait, but estimator.time.model is none and no estimator is busy");
  require(time.on_busy == OnBusy::drop || time.queue == 0, "queue",
          "is 1, but estimator.time.on_busy is wait, where every frame waits; expected 0, or on_busy: drop");
}

/// Throws ConfigError for limits that no run satisfies. turn_rad: of the whole walk.
void check_limits(const ReadScenario& read, const Yaml& at, double turn_rad) {
  const std::vector<MetricLimit>& limits = read.scenario.limits.metrics;
  for (const MetricLimit& most : limits)
    for (const MetricLimit& least : limits)
      if (subject(most) == subject(least) && most.bound == Bound::at_most && least.bound == Bound::at_least &&
          least.value > most.value)
        fail(at, "limits." + subject(most),
             fmt::format("contradicts itself: at_least {} is above at_most {}", least.value, most.value));
  constexpr double kLoop_rad = 350 * std::numbers::pi / 180;  // as loop_closed defines it
  for (const MetricLimit& limit : limits)
    if (limit.metric == "loop_closed" && limit.bound == Bound::at_least && limit.value > 0 &&
        turn_rad < kLoop_rad)
      fail(at, "limits." + subject(limit),
           fmt::format("cannot be met: the walk turns by {:.0f} degrees, expected at least 350; limits: {{}} "
                       "removes the limits of a base",
                       turn_rad * 180 / std::numbers::pi));
}

}  // namespace

void check_whole(const ReadScenario& read, const Yaml& at) {
  const Scenario& scenario = read.scenario;
  if (scenario.walk.commands.empty()) {
    fail(at, "walk.commands", "missing, expected a list of commands, as in [{stand: {duration_s: 1}}]");
  }
  if (scenario.slam && !scenario.camera) {
    fail(at, "slam",
         "needs the section 'camera': the filter works at its frames (--without camera,slam drops both)");
  }
  check_time(read, at);
  check_measured_depth(read, at);
  if (!scenario.rig.empty() && !scenario.camera)
    fail(at, "rig", "needs the section 'camera': its readings come with the frames of the head camera");
  if (scenario.slam && scenario.slam->vision.enabled && scenario.world.room == "floor")
    fail(at, "world.room",
         "is floor, where the camera sees nothing to track; expected office or hall, or slam.vision.enabled: "
         "false");
  using enum walking::SteeredBy;
  const walking::SteeredBy steered_by = scenario.walk.steering.by;
  if (steered_by == estimate && !scenario.slam)
    fail(at, "walk.steering.by", "is estimate, which needs the sections 'camera' and 'slam'");
  for (const sensor_errors::Fault& fault : scenario.errors.faults)
    if (steered_by == plan && sensor_errors::is_of_steering(fault))
      fail(at, "errors.faults",
           "disturb the estimate that steers, but walk.steering.by is plan; expected truth or estimate");
  const std::optional<walking::Timeline> walk = planned(read, at);
  if (!walk) return;
  double turn_rad = 0;
  for (const walking::Phase& phase : walk->phases())
    turn_rad += std::abs(phase.waist_yaw_to - phase.waist_yaw_from);
  check_limits(read, at, turn_rad);
  const double walk_s = static_cast<double>(walk->ticks()) * walking::kPeriod;
  check_happens(read, at, steered_by == plan ? walk_s : 2 * walk_s);  // steering adds steps
}

std::string to_yaml(const Scenario& scenario) {
  std::string text, before;
  for (const Key& key : scenario_keys()) {
    const std::string& name = key.name;
    if (!has_section(scenario, name)) continue;
    std::size_t begin = 0, indent = 0;  // "a: \n  b: value" for "a.b", with sections that are not open yet
    for (std::size_t dot = 0; (dot = name.find('.', dot + 1)) != name.npos;) {
      if (find_key(name.substr(0, dot))) continue;  // "estimator.time:", as `estimator` has a value
      if (!before.starts_with(name.substr(0, dot + 1)))
        text += fmt::format("{:{}}{}:\n", "", indent, name.substr(begin, dot - begin));
      begin = dot + 1, indent += 2;
    }
    text += fmt::format("{:{}}{}: {}\n", "", indent, name.substr(begin), key.print(scenario));
    before = name;
  }
  for (const MetricLimit& limit : scenario.limits.metrics)
    text += fmt::format("  {}.{}: {}\n", subject(limit), word(limit.bound), limit.value);
  return text;
}

}  // namespace sim::scenario
