#include "sim/scenario/scenario.h"

#include <fmt/format.h>

#include "sim/scenario/keys.h"
#include "sim/scenario/limits.h"
#include "sim/scenario/yaml.h"
#include "walking/timeline.h"

namespace sim::scenario {
namespace {

/// Throws ConfigError at the command that makes the walk too long.
void check_length(const ReadScenario& read, const Yaml& root) {
  try {
    walking::Timeline(read.scenario.walk, {}, Eigen::Vector2d::Zero());
  } catch (const walking::TooLong& e) {
    const auto command = static_cast<std::size_t>(e.command());
    Yaml at = root;
    if (command < read.command_origins.size()) at.origin = read.command_origins[command];
    fail(at, "", e.what());
  } catch (const std::invalid_argument&) {  // reported when the walk is planned
  }
}

/// Writes "a: \n  b: value" for "a.b", repeating only the sections that change from key to key.
class YamlWriter {
 public:
  void write(std::string_view path, const std::string& value) {
    const std::vector<std::string_view> parts = split(path);
    std::size_t same = 0;
    while (same + 1 < parts.size() && same < open_.size() && open_[same] == parts[same]) ++same;
    open_.assign(parts.begin(), parts.end() - 1);
    for (std::size_t i = same; i + 1 < parts.size(); ++i)
      text += fmt::format("{:{}}{}:\n", "", 2 * i, parts[i]);
    text += fmt::format("{:{}}{}: {}\n", "", 2 * (parts.size() - 1), parts.back(), value);
  }
  std::string text;

 private:
  static std::vector<std::string_view> split(std::string_view path) {
    std::vector<std::string_view> parts;
    for (std::size_t dot; (dot = path.find('.')) != std::string_view::npos; path.remove_prefix(dot + 1)) {
      parts.push_back(path.substr(0, dot));
    }
    parts.push_back(path);
    return parts;
  }
  std::vector<std::string_view> open_;
};

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
  using enum walking::SteeredBy;
  const walking::SteeredBy steered_by = scenario.walk.steering.by;
  if (steered_by == estimate && !scenario.slam)
    fail(at, "walk.steering.by", "is estimate, which needs the sections 'camera' and 'slam'");
  for (const sensor_errors::Fault& fault : scenario.errors.faults)
    if (steered_by == plan && sensor_errors::is_of_steering(fault))
      fail(at, "errors.faults",
           "disturb the estimate that steers, but walk.steering.by is plan; expected truth or estimate");
  check_length(read, at);
}

std::string to_yaml(const Scenario& scenario) {
  YamlWriter yaml;
  for (const auto& key : scenario_keys()) {
    if (has_section(scenario, key.name)) yaml.write(key.name, key.print(scenario));
  }
  return yaml.text + print_limits(scenario.limits.metrics);
}

}  // namespace sim::scenario
