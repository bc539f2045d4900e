#include "sim/scenario/scenario.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "sim/files/hash.h"
#include "sim/model_file/model_file.h"
#include "sim/scenario/keys.h"
#include "sim/scenario/robot.h"
#include "walking/timeline.h"

namespace sim::scenario {
namespace {

/// Returns the planned walk, or nothing if it cannot be carried out, which is reported when it is planned.
/// Throws ConfigError at the command that makes the walk too long.
std::optional<walking::Timeline> planned(const ReadScenario& read) {
  try {
    // A robot without size. Its plan may have one step fewer than a real robot's, which must close its feet.
    return walking::Timeline({}, read.scenario.walk, {}, Eigen::Vector2d::Zero());
  } catch (const walking::TooLong& e) {
    const auto command = std::size_t(e.command);
    Yaml at = place_of(read, "");
    if (command < read.command_origins.size()) at.origin = read.command_origins[command];
    fail(at, "", e.what());
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

constexpr const char* kArgument = "<argument>";
constexpr const char* kNoCamera = "never happens: this scenario has no section 'camera'";

/// Returns why a fault, push or darkness at this time never happens, if so. end_s: the end of the walk.
std::optional<std::string> never_happens(double from_s, double duration_s, double end_s) {
  if (duration_s == 0) return "never happens: its duration_s is 0";
  if (from_s >= end_s)
    return fmt::format("never happens: it starts at {} s, the walk ends at {:.1f} s", from_s, end_s);
  return std::nullopt;
}

std::optional<std::string> never_happens(const sensor_errors::Fault& any, const Scenario& scenario,
                                         double end_s) {
  if (!sensor_errors::is_of_steering(any) && !scenario.camera) return kNoCamera;
  return std::visit([&](const auto& fault) { return never_happens(fault.from_s, fault.duration_s, end_s); },
                    any);
}

/// Throws ConfigError for a fault, push or darkness that never happens. Pushes of a file after the end of
/// commands that replace the file's are removed with a warning.
void check_happens(ReadScenario& read, double end_s) {
  Scenario& scenario = read.scenario;
  const auto require = [&](const std::string& name, const std::optional<std::string>& problem) {
    if (problem) fail(place_of(read, name.substr(0, name.find(':'))), name, *problem);
  };
  for (const sensor_errors::Fault& fault : scenario.errors.faults) {
    const std::string kind = std::visit([](const auto& f) { return f.kName; }, fault);
    require("errors.faults: " + kind, never_happens(fault, scenario, end_s));
  }
  const Yaml pushes = place_of(read, "world.pushes");
  const bool replaced =
      place_of(read, "walk.commands").origin.file == kArgument && pushes.origin.file != kArgument;
  std::erase_if(scenario.world.pushes, [&](const physics::Push& push) {
    if (push.impulse_ns == 0) require("world.pushes: push", "never happens: its impulse_ns is 0");
    const auto problem = never_happens(push.time_s, push.duration_s, end_s);
    if (problem && replaced)
      read.warnings.push_back(fmt::format("{}:{}:{}: world.pushes: push: {}; ignored", pushes.origin.file,
                                          pushes.origin.line, pushes.origin.column, *problem));
    else
      require("world.pushes: push", problem);
    return problem.has_value();
  });
  const physics::WorldOptions::LightsOff& dark = scenario.world.lights_off;
  if (dark.from_s == 0 && dark.duration_s == 0) return;
  require("world.lights_off", never_happens(dark.from_s, dark.duration_s, end_s));
  if (!scenario.camera) require("world.lights_off", kNoCamera);
}

/// Throws ConfigError if landmarks should start with a measured depth and the rig does not measure it.
void check_measured_depth(const ReadScenario& read) {
  const Scenario& scenario = read.scenario;
  const auto measures_head_depth = [](const rig::Item& item) {
    const auto* depth = std::get_if<rig::DepthCamera>(&item);
    return depth && depth->aligned_with == "cam0";
  };
  if (!scenario.slam || scenario.slam->depth.first_sight != slam::FirstSight::measured_depth ||
      std::ranges::any_of(scenario.rig, measures_head_depth))
    return;
  constexpr const char* kKey = "slam.depth.first_sight";
  fail(place_of(read, kKey), kKey,
       "is measured_depth, expected a depth camera in the rig that is aligned with cam0, as in rig: d435i");
}

/// Throws ConfigError at a key of estimator.time or walk.controller.time that contradicts another one.
void check_time(const ReadScenario& read) {
  const auto require = [&](bool valid, const std::string& key, const std::string& problem) {
    if (!valid) fail(place_of(read, key), key, problem);
  };
  const auto check_fixed = [&](const std::string& section, TimeModel model, const std::string& name) {
    require(model != TimeModel::fixed || read.origin.contains(section + name), section + "model",
            fmt::format("is fixed, expected {}{} to be set with it", section, name));
  };
  const ControllerTime& controller = read.scenario.controller_time;
  check_fixed("walk.controller.time.", controller.model, "answer_ms");
  require(controller.model == TimeModel::none || read.scenario.controller.source == programs::Source::program,
          "walk.controller.time.model", "needs an external program as walk.controller, expected none");
  check_fixed("estimator.time.", read.scenario.estimator_time.model, "frame_ms");
}

/// Throws ConfigError if a session is not valid.
void check_sessions(const ReadScenario& read) {
  if (read.scenario.sessions.empty()) return;
  if (!read.scenario.slam || !read.scenario.slam->map.load.empty())
    fail(place_of(read, "sessions"), "sessions", "give the map, expected slam, without slam.map.load");
  for (std::size_t i = 0; i < read.scenario.sessions.size(); ++i) session(read, i);
}

/// Throws ConfigError for limits that no run can satisfy.
void check_limits(const ReadScenario& read, const Yaml& at) {
  const std::vector<MetricLimit>& limits = read.scenario.limits.metrics;
  for (const MetricLimit& most : limits)
    for (const MetricLimit& least : limits)
      if (subject(most) == subject(least) && most.bound == Bound::at_most && least.bound == Bound::at_least &&
          least.value > most.value)
        fail(at, "limits." + subject(most), "contradicts itself: at_least {} is above at_most {}",
             least.value, most.value);
}

/// Throws ConfigError if keys contradict each other, a fault never happens, or the walk takes too long to
/// plan.
void check_whole(ReadScenario& read) {
  const Scenario& scenario = read.scenario;
  const Yaml at = place_of(read, "");
  if (scenario.walk.commands.empty())
    fail(at, "walk.commands", "missing, expected a list of commands, as in [{stand: {duration_s: 1}}]");
  check_time(read);
  if (scenario.slam && !scenario.camera)
    fail(at, "slam",
         "needs the section 'camera': the filter works at its frames (--without camera,slam drops both)");
  check_measured_depth(read);
  check_sessions(read);
  if (!scenario.rig.empty() && !scenario.camera)
    fail(at, "rig", "needs the section 'camera': its readings come with the head camera's frames");
  if (scenario.slam && scenario.slam->vision.enabled && scenario.world.room == "floor")
    fail(at, "world.room",
         "is floor, an empty plane without anything to track; expected office or hall, or "
         "slam.vision.enabled: false");
  using enum walking::SteeredBy;
  const walking::SteeredBy steered_by = scenario.walk.steering.by;
  if (steered_by == estimate && !scenario.slam)
    fail(at, "walk.steering.by", "is estimate, which needs the sections 'camera' and 'slam'");
  for (const sensor_errors::Fault& fault : scenario.errors.faults)
    if ((steered_by == plan || steered_by == legs) && sensor_errors::is_of_steering(fault))
      fail(
          at, "errors.faults",
          fmt::format("disturb the steering estimate, but walk.steering.by is {}; expected truth or estimate",
                      walking::kSteeredBy[std::size_t(steered_by)]));
  const std::optional<walking::Timeline> walk = planned(read);
  if (!walk) return;
  check_limits(read, at);
  const double walk_s = double(walk->ticks()) * walking::kPeriod;
  check_happens(read, steered_by == plan ? walk_s : 2 * walk_s);  // steering adds steps
}

constexpr const char* kBase = "base";  // not in the table of keys

/// Returns the parts below `section` ("" for the top): "walk" -> {"single_support_s", ...}. Not empty only
/// for a section.
std::vector<std::string_view> parts_below(std::string_view section) {
  std::vector<std::string_view> parts;
  for (const auto& key : scenario_keys()) {
    std::string_view rest = key.name;
    if (!section.empty()) {
      if (!rest.starts_with(section) || rest.substr(section.size(), 1) != ".") continue;
      rest.remove_prefix(section.size() + 1);
    }
    rest = rest.substr(0, rest.find('.'));
    if (parts.empty() || parts.back() != rest) parts.push_back(rest);
  }
  return parts;
}

bool is_section(std::string_view path) { return !parts_below(path).empty(); }

/// Fills a scenario from files and overrides; later values replace earlier ones. Throws ConfigError.
class ScenarioReader {
 public:
  ReadScenario result;

  /// Reads all keys of a file after reading its bases. root.origin.file: its path.
  void read_file(const Yaml& root) {
    if (!root.is_map()) fail(root, "", "expected keys and values, as in slam.gyro.sigma_rad_s: 0.01");
    open_files_.emplace_back(root.origin.file);
    if (const Yaml* const base = root.find(kBase)) {
      const bool list = base->is_list() && !base->items.empty();
      for (const Yaml& node : list ? std::span(base->items) : std::span(base, 1)) read_base(node);
    }
    open_files_.pop_back();
    given_.clear();
    read_map(root, "");
  }

  /// Names the scenario after the file unless it has a key `name`. A base's name is not inherited.
  void read_name_of_file(const Yaml& root) {
    if (root.find("name")) return;
    Yaml stem;
    stem.kind = Yaml::Kind::scalar;
    stem.text = fs::path(root.origin.file).stem().string();
    stem.origin = {root.origin.file};
    find_key("name")->read(stem, result.scenario);
    result.origin.erase("name");
  }

  /// Reads the robot's values for keys that no file or argument has set.
  void read_robot_defaults() {
    for (const auto& [path, value] :
         robot_defaults(robot_folder(result.scenario.world.robot), result.scenario.walk.gait)) {
      const bool noise = find_key(path) &&
                         (path.starts_with("slam.start.") || path.starts_with("slam.height.") ||
                          path.starts_with("slam.leg_odometry.") || path.starts_with("slam.plan_velocity."));
      if (result.origin.contains(path) || (noise && !result.scenario.slam)) continue;
      if (!noise && (!shapes_recording(path) || path == "walk.commands"))
        fail(value, path,
             "is not a default that a robot can set" + (find_key(path) ? "" : "; " + unknown_key(path)));
      read_value(value, path, value);
      result.origin[path] = fmt::format("{}:{}", value.origin.file, value.origin.line);
      result.places[path] = value.origin;
    }
    const walking::WalkOptions& walk = result.scenario.walk;
    if (result.scenario.slam && !result.origin.contains("slam.plan_velocity.sway_period_s"))
      result.scenario.slam->plan_velocity.sway_period_s = 2 * (walk.single_support_s + walk.double_support_s);
  }

  /// Reads "key=value" or "section={key: value}", the n-th on the command line (from 1).
  void read_override(const std::string& argument, int n) {
    const std::size_t equals = argument.find('=');
    Yaml at;
    at.origin = {kArgument, n, 1};
    if (equals == std::string::npos || equals == 0) fail(at, "", "'{}': expected key=value", argument);
    const Yaml value = parse_yaml(argument.substr(equals + 1), {kArgument, n, int(equals) + 2});
    read_setting({argument.substr(0, equals), at, value});
  }

  /// Reads a setting, which replaces an earlier one.
  void read_setting(const Setting& setting) {
    given_.clear();
    read_entry(setting.at, setting.key, setting.value);
  }

 private:
  void read_base(const Yaml& node) {
    if (!node.is_scalar() || node.text.empty())
      fail(node, kBase, "expected a scenario file or a list of them, as in base: tangent_circle.yaml");
    const fs::path file = (fs::path(node.origin.file).parent_path() / node.text).lexically_normal();
    for (const fs::path& open : open_files_) {
      std::error_code fault;
      if (open == file || fs::equivalent(open, file, fault))
        fail(node, kBase, "{} is a base of itself, through {}", file.string(), open_files_.back().string());
    }
    std::string text;
    try {
      text = yaml_text(file);
    } catch (const ConfigError& e) {
      fail(node, kBase, e.what());
    }
    read_file(parse_yaml(text, {file.string()}));
  }

  void read_map(const Yaml& map, const std::string& section) {
    for (const auto& [key, value] : map.entries()) {
      const std::string& part = key.text;
      if (section.empty() && part == kBase) continue;  // already read by read_file
      read_entry(key, section.empty() ? part : section + "." + part, value);
    }
  }

  void read_entry(const Yaml& at, const std::string& path, const Yaml& value) {
    const bool limit = path.starts_with("limits.");
    if ((path == "estimator" || path == "walk.controller") && value.find("time"))
      return read_timed(at, path, value);
    if (value.is_map() && find_key(path) == nullptr && (limit || is_section(path))) {
      if (limit && value.keys.empty()) fail(at, path, "is empty, expected at_most or at_least");
      if (!limit) require_section(at, path);
      if (path == "limits" && value.keys.empty())
        result.scenario.limits.metrics.clear();  // removes the bases' limits
      return read_map(value, path);
    }
    // `a.b: 1` and `a: {b: 2}` name the same key.
    const auto [earlier, first] = given_.emplace(path, fmt::format("{}:{}", at.origin.file, at.origin.line));
    if (!first) fail(at, path, "given twice, first at {}", earlier->second);
    read_value(at, path, value);
    result.origin[path] =
        at.origin.file == kArgument ? fmt::format("argument {}", at.origin.line) : given_[path];
    result.places[path] = at.origin;
  }

  // In {program: ..., time: {...}}, the time is a section, separate from the choice of the program.
  void read_timed(const Yaml& at, const std::string& path, Yaml value) {
    const auto i = value.find("time") - value.items.data();
    read_entry(value.keys[std::size_t(i)], path + ".time", Yaml(*value.find("time")));
    value.keys.erase(value.keys.begin() + i), value.items.erase(value.items.begin() + i);
    if (!value.keys.empty()) read_entry(at, path, value);
  }

  void read_value(const Yaml& at, const std::string& path, const Yaml& value) {
    if (const Key* const key = find_key(path)) {
      require_section(at, path);
      Yaml placed = value;
      if (value.kind == Yaml::Kind::empty) placed.origin = at.origin;
      key->read(placed, result.scenario);
      physics::WorldOptions& world = result.scenario.world;
      if (path == "world.robot" && world.robot.is_path()) world.robot = resolved(at, world.robot);
      if (path == "world.room" && world.room.is_path()) world.room = resolved(at, world.room);
      if (path == "slam.map.load")
        if (fs::path& map = result.scenario.slam->map.load; !map.empty()) map = resolved(at, map.string());
      if (path != "walk.commands") return;
      result.command_origins.clear();
      for (const Yaml& command : placed.items) result.command_origins.push_back(command.origin);
    } else if (path.starts_with("limits.")) {
      read_limit(at, path, value, result.scenario.limits.metrics);
    } else if (is_section(path)) {
      fail(at, path, "is a section, expected keys below it: {}", fmt::join(parts_below(path), ", "));
    } else if (path == kBase) {
      fail(at, path, "belongs in a scenario file; --with FILE adds a file's keys");
    } else {
      fail(at, path, unknown_key(path));
    }
  }

  /// A path is relative to the file that names it, or to the working folder.
  static std::string resolved(const Yaml& at, const std::string& named) {
    const fs::path folder = at.origin.file == kArgument ? fs::path() : fs::path(at.origin.file).parent_path();
    const fs::path path = fs::absolute(folder / named).lexically_normal();
    return (path.has_filename() ? path : path.parent_path()).string();
  }

  // In a file, `slam.gyro.enabled: true` or `estimator` creates the section as `slam:` would. An argument
  // does not.
  void require_section(const Yaml& at, const std::string& path) {
    const std::string first = path.substr(0, path.find('.')), section = first == "estimator" ? "slam" : first;
    Scenario& scenario = result.scenario;
    if (at.origin.file != kArgument && section == "camera" && !scenario.camera) scenario.camera.emplace();
    if (at.origin.file != kArgument && section == "slam" && !scenario.slam) scenario.slam.emplace();
    if (!has_section(scenario, path)) fail(at, path, "this scenario has no section '{}'", section);
  }

  std::vector<fs::path> open_files_;          // each one is a base of the previous one
  std::map<std::string, std::string> given_;  // keys of the current file, and where
};

void leave_out(Scenario& scenario, const std::vector<std::string>& without) {
  static constexpr std::string_view kSections[]{"camera", "slam"};
  for (const std::string& section : without) {
    if (section == "camera") {
      scenario.camera.reset();
      scenario.world.lights_off = {};
      scenario.rig.clear();
    } else if (section == "slam") {
      scenario.slam.reset();
    } else {
      throw ConfigError(
          fmt::format("--without {}: expected camera or slam{}", section, did_you_mean(section, kSections)));
    }
    std::erase_if(scenario.errors.faults,  // there is no filter without both
                  [](const auto& fault) { return !sensor_errors::is_of_steering(fault); });
  }
}

/// The time of a steering estimator is its latency. A given latency_s is added to it.
void derive_latency(ReadScenario& read) {
  constexpr const char* kLatency = "walk.steering.latency_s";
  walking::SteeringOptions& steering = read.scenario.walk.steering;
  if (read.scenario.estimator_time.model == TimeModel::none || read.origin.contains(kLatency) ||
      steering.by != walking::SteeredBy::estimate)
    return;
  steering.latency_s = 0;
  read.origin[kLatency] = "estimator.time";
}

ReadScenario read_root(const Yaml& root, const Changes& changes) {
  if (!root.is_map()) fail(root, "", "expected a scenario: keys and values, as in seed: 1");
  ScenarioReader reader;
  reader.result.start = root.origin;
  reader.read_file(root);
  reader.read_name_of_file(root);
  for (const std::string& overlay : changes.with) reader.read_file(parse_yaml_file(overlay));
  int n = 0;
  for (const std::string& argument : changes.overrides) reader.read_override(argument, ++n);
  for (const Setting& setting : changes.settings) reader.read_setting(setting);
  reader.read_robot_defaults();
  leave_out(reader.result.scenario, changes.without);
  derive_latency(reader.result);
  check_whole(reader.result);
  return reader.result;
}

std::vector<fs::path> files_below(const fs::path& folder) {
  std::error_code fault;
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder, fault))
    if (entry.is_regular_file() && entry.path().extension() != ".md") files.push_back(entry.path());
  if (fault || files.empty()) throw files::FileError(folder, "has no models");
  std::ranges::sort(files);
  return files;
}

}  // namespace

Yaml place_of(const ReadScenario& read, std::string_view key) {
  Yaml at;
  at.origin = read.start;
  if (at.origin.file.empty()) at.origin.file = read.scenario.name;  // the scenario was not read from text
  if (const auto place = read.places.find(key); place != read.places.end()) at.origin = place->second;
  return at;
}

ReadScenario read_scenario(const fs::path& file, const Changes& changes) {
  return read_root(parse_yaml_file(file), changes);
}

ReadScenario read_scenario_text(std::string_view text, const std::string& file_name, const Changes& changes) {
  return read_root(parse_yaml(text, {file_name}), changes);
}

ReadScenario session(const ReadScenario& read, std::size_t index) {
  constexpr std::uint64_t kOtherNoise = 1'000'003;
  constexpr std::array kMayDiffer{"walk.",         "world.room",    "world.start",  "world.light",
                                  "world.moved",   "world.floor",   "world.pushes", "world.actors",
                                  "errors.faults", "slam.map.start"};
  const Yaml at = place_of(read, "sessions");
  Scenario scenario = read.scenario;
  const Session session = scenario.sessions[index];
  for (const std::string& setting : session.set)
    if (std::ranges::none_of(kMayDiffer, [&](const char* start) { return setting.starts_with(start); }))
      fail(at, "sessions", "session {} sets '{}', expected keys that start with {}", index + 1, setting,
           fmt::join(kMayDiffer, ", "));
  scenario.sessions.clear();
  if (scenario.world.variation.seed == 0) scenario.world.variation.seed = scenario.seed;
  scenario.seed += kOtherNoise * (index + 1);
  scenario.slam->map.save = true;
  try {
    ReadScenario made = read_scenario_text(to_yaml(scenario), read.start.file, {session.set, {}});
    for (auto& [key, origin] : made.origin) {
      const auto given = read.origin.find(origin.starts_with("argument") ? "sessions" : key);
      origin = given == read.origin.end() ? "" : given->second;
    }
    std::erase_if(made.origin, [](const auto& each) { return each.second.empty(); });
    return made;
  } catch (const ConfigError& error) {
    fail(at, "sessions", "session {}: {}", index + 1, error.what());
  }
}

std::string to_yaml(const Scenario& scenario, std::initializer_list<std::string_view> starts) {
  std::string text, before;
  for (const Key& key : scenario_keys()) {
    const std::string& name = key.name;
    if (!has_section(scenario, name) ||
        std::ranges::none_of(starts, [&](std::string_view start) { return name.starts_with(start); }))
      continue;
    std::size_t begin = 0, indent = 0;  // "a: \n  b: value" for "a.b", for sections that are not open yet
    for (std::size_t dot = 0; (dot = name.find('.', dot + 1)) != name.npos;) {
      if (find_key(name.substr(0, dot))) continue;  // "estimator.time:", because `estimator` has a value
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

std::string models_hash(const fs::path& models) {
  files::Hash hash;
  for (const fs::path& file : files_below(models)) {
    hash.add_part(file.lexically_relative(models).generic_string());
    hash.add_part(files::read_text(file));
  }
  return hash.hex();
}

std::string recording_key(const Scenario& scenario, const std::string& models, const std::string& program) {
  files::Hash hash;
  hash.add_part("recording 1");
  hash.add_part(program);
  hash.add_part(models);
  const auto add_files = [&](const fs::path& model, const model_file::Packages& packages = {}) {
    for (const fs::path& file : model_file::files_of(model, packages)) hash.add_part(files::read_text(file));
  };
  if (const fs::path folder = std::string(scenario.world.robot); scenario.world.robot.is_path()) {
    const physics::RobotFile robot = read_robot(folder);
    hash.add_part(files::read_text(folder / "robot.yaml"));
    add_files(folder / robot.model, robot.packages);
  }
  if (scenario.world.room.is_path()) add_files(std::string(scenario.world.room));
  hash.add_part(fmt::format("seed {}{}", scenario.seed, programs::files_identity(scenario.controller)));
  for (const auto& key : scenario_keys()) {
    if (!shapes_recording(scenario, key.name) || !has_section(scenario, key.name)) continue;
    hash.add_part(key.name);
    hash.add_part(key.print(scenario));
  }
  return hash.hex();
}

}  // namespace sim::scenario
