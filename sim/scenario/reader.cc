#include <fmt/format.h>
#include <fmt/ranges.h>

#include <span>

#include "sim/scenario/keys.h"
#include "sim/scenario/scenario.h"

namespace sim::scenario {
namespace {

namespace fs = std::filesystem;

constexpr const char* kArgument = "<argument>";
constexpr const char* kBase = "base";  // not in the table of keys

/// Parts below `section` ("" for the top): "walk" -> {"single_support_s", ...}. Not empty for a section only.
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

/// Suggests a part of the longest known section, else a key of another section, else lists the parts.
[[noreturn]] void fail_unknown(const Yaml& at, const std::string& path) {
  if (const std::string former = former_name(path); !former.empty()) fail(at, path, former);
  std::string section = path;
  do {
    const std::size_t dot = section.rfind('.');
    section.resize(dot == std::string::npos ? 0 : dot);
  } while (!section.empty() && !is_section(section));
  std::vector<std::string> full;
  if (section.empty()) full.emplace_back(kBase);
  for (const std::string_view name : parts_below(section))
    full.push_back((section.empty() ? "" : section + ".") + std::string(name));
  std::string hint = did_you_mean(path, std::vector<std::string_view>(full.begin(), full.end()));
  const std::string last = "." + path.substr(path.rfind('.') + 1);
  for (const Key& key : scenario_keys())
    if (hint.empty() && key.name.ends_with(last)) hint = fmt::format("; did you mean '{}'?", key.name);
  if (hint.empty()) hint = fmt::format("; expected one of {}", fmt::join(full, ", "));
  fail(at, path, "unknown key" + hint);
}

/// Fills a scenario from files and overrides; later values replace earlier ones. Throws ConfigError.
class ScenarioReader {
 public:
  ReadScenario result;

  /// Reads all keys of a file, after those of its bases. root.origin.file: its path.
  void read_file(const Yaml& root) {
    if (root.kind != Yaml::Kind::map)
      fail(root, "", "expected keys and values, as in slam.gyro.sigma_rad_s: 0.01");
    open_files_.emplace_back(root.origin.file);
    if (const Yaml* const base = find(root, kBase)) {
      const bool list = base->kind == Yaml::Kind::list && !base->items.empty();
      for (const Yaml& node : list ? std::span(base->items) : std::span(base, 1)) read_base(node);
    }
    open_files_.pop_back();
    given_.clear();
    read_map(root, "");
  }

  /// Names the scenario after the file, unless it has a key `name`; the name of a base is not inherited.
  void read_name_of_file(const Yaml& root) {
    if (find(root, "name")) return;
    Yaml stem;
    stem.kind = Yaml::Kind::scalar;
    stem.text = fs::path(root.origin.file).stem().string();
    stem.origin = {root.origin.file};
    find_key("name")->read(stem, result.scenario);
    result.origin.erase("name");
  }

  /// "key=value" or "section={key: value}", the n-th of the command line (from 1).
  void read_override(const std::string& argument, int n) {
    const std::size_t equals = argument.find('=');
    Yaml at;
    at.origin = {kArgument, n, 1};
    if (equals == std::string::npos || equals == 0)
      fail(at, "", fmt::format("'{}': expected key=value", argument));
    const Yaml value = parse_yaml(argument.substr(equals + 1), {kArgument, n, static_cast<int>(equals) + 2});
    given_.clear();  // a later argument replaces an earlier one
    read_entry(at, argument.substr(0, equals), value);
  }

 private:
  static const Yaml* find(const Yaml& map, std::string_view name) {
    for (std::size_t i = 0; i < map.keys.size(); ++i)
      if (map.keys[i].text == name) return &map.items[i];
    return nullptr;
  }

  void read_base(const Yaml& node) {
    if (node.kind != Yaml::Kind::scalar || node.text.empty())
      fail(node, kBase, "expected a scenario file or a list of them, as in base: tangent_circle.yaml");
    const fs::path file = (fs::path(node.origin.file).parent_path() / node.text).lexically_normal();
    for (const fs::path& open : open_files_) {
      std::error_code fault;
      if (open == file || fs::equivalent(open, file, fault))
        fail(node, kBase,
             fmt::format("{} is a base of itself, by way of {}", file.string(), open_files_.back().string()));
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
    for (std::size_t i = 0; i < map.keys.size(); ++i) {
      const std::string& part = map.keys[i].text;
      if (section.empty() && part == kBase) continue;  // read_file has read it
      read_entry(map.keys[i], section.empty() ? part : section + "." + part, map.items[i]);
    }
  }

  void read_entry(const Yaml& at, const std::string& path, const Yaml& value) {
    const bool limit = path.starts_with("limits.");
    if (path == "estimator" && find(value, "time")) return read_estimator(at, value);
    if (value.kind == Yaml::Kind::map && find_key(path) == nullptr && (limit || is_section(path))) {
      if (limit && value.keys.empty()) fail(at, path, "is empty, expected at_most or at_least");
      if (!limit) require_section(at, path);
      if (path == "limits" && value.keys.empty()) result.scenario.limits.metrics.clear();  // of the bases
      return read_map(value, path);
    }
    // `a.b: 1` and `a: {b: 2}` name the same key.
    const auto [earlier, first] = given_.emplace(path, fmt::format("{}:{}", at.origin.file, at.origin.line));
    if (!first) fail(at, path, fmt::format("given twice, first at {}", earlier->second));
    read_value(at, path, value);
    result.origin[path] =
        at.origin.file == kArgument ? fmt::format("argument {}", at.origin.line) : given_[path];
    result.places[path] = at.origin;
  }

  // {program: ..., time: {...}}: the time is a section beside the choice of the estimator.
  void read_estimator(const Yaml& at, Yaml value) {
    const auto i = find(value, "time") - value.items.data();
    read_entry(value.keys[static_cast<std::size_t>(i)], "estimator.time", Yaml(*find(value, "time")));
    value.keys.erase(value.keys.begin() + i), value.items.erase(value.items.begin() + i);
    if (!value.keys.empty()) read_entry(at, "estimator", value);
  }

  void read_value(const Yaml& at, const std::string& path, const Yaml& value) {
    if (const Key* const key = find_key(path)) {
      require_section(at, path);
      Yaml placed = value;
      if (value.kind == Yaml::Kind::empty) placed.origin = at.origin;
      key->read(placed, result.scenario);
      if (path != "walk.commands") return;
      result.command_origins.clear();
      for (const Yaml& command : placed.items) result.command_origins.push_back(command.origin);
    } else if (path.starts_with("limits.")) {
      read_limit(at, path, value, result.scenario.limits.metrics);
    } else if (is_section(path)) {
      fail(at, path,
           fmt::format("is a section, expected keys below it: {}", fmt::join(parts_below(path), ", ")));
    } else if (path == kBase) {
      fail(at, path, "belongs in a scenario file; --with FILE lays keys over one");
    } else {
      fail_unknown(at, path);
    }
  }

  // In a file `slam.gyro.enabled: true` starts the section as `slam:` would; an argument does not.
  void require_section(const Yaml& at, const std::string& path) {
    const std::string section = path.substr(0, path.find('.'));
    Scenario& scenario = result.scenario;
    if (at.origin.file != kArgument && section == "camera" && !scenario.camera) scenario.camera.emplace();
    if (at.origin.file != kArgument && section == "slam" && !scenario.slam) scenario.slam.emplace();
    if (!has_section(scenario, path))
      fail(at, path, fmt::format("this scenario has no section '{}'", section));
  }

  std::vector<fs::path> open_files_;          // each but the first is a base of the one before
  std::map<std::string, std::string> given_;  // keys of the file at hand, and where
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
    std::erase_if(scenario.errors.faults,  // no filter works without either
                  [](const auto& fault) { return !sensor_errors::is_of_steering(fault); });
  }
}

/// The time of the estimator that steers is its latency; a given latency_s is added to it.
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
  if (root.kind != Yaml::Kind::map) fail(root, "", "expected a scenario: keys and values, as in seed: 1");
  ScenarioReader reader;
  reader.read_file(root);
  reader.read_name_of_file(root);
  for (const std::string& overlay : changes.with) reader.read_file(parse_yaml_file(overlay));
  int n = 0;
  for (const std::string& argument : changes.overrides) reader.read_override(argument, ++n);
  leave_out(reader.result.scenario, changes.without);
  derive_latency(reader.result);
  check_whole(reader.result, root);
  return reader.result;
}

}  // namespace

ReadScenario read_scenario(const fs::path& file, const Changes& changes) {
  return read_root(parse_yaml_file(file), changes);
}

ReadScenario read_scenario_text(std::string_view text, const std::string& file_name, const Changes& changes) {
  return read_root(parse_yaml(text, {file_name}), changes);
}

}  // namespace sim::scenario
