#include "sim/bench/scenario.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "sim/bench/scenario_keys.h"
#include "sim/bench/scenario_limits.h"
#include "sim/bench/scenario_yaml.h"

namespace sim::bench {
namespace {

/// The parts that can follow `section` ("" for the top): "walk" -> {"single_support_s", ...}.
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

/// All full names whose last part is near: the key may exist, but in another section.
std::string suggest_elsewhere(std::string_view part) {
  for (const auto& key : scenario_keys()) {
    if (std::string_view(key.name).substr(key.name.rfind('.') + 1) == part) {
      return fmt::format("; did you mean '{}'?", key.name);
    }
  }
  return "";
}

/// Names the longest known section of the path, and what it has.
[[noreturn]] void fail_unknown(const Yaml& at, const std::string& path) {
  std::string section = path;
  std::string_view part;
  do {
    const std::size_t dot = section.rfind('.');
    part = std::string_view(path).substr(dot + 1);
    section.resize(dot == std::string::npos ? 0 : dot);
  } while (!section.empty() && !is_section(section));
  const std::vector<std::string_view> known = parts_below(section);
  const std::string prefix = section.empty() ? "" : section + ".";
  std::vector<std::string> full;
  for (const std::string_view name : known) full.push_back(prefix + std::string(name));
  const std::vector<std::string_view> candidates(full.begin(), full.end());
  std::string hint = did_you_mean(path, candidates);
  if (hint.empty()) hint = suggest_elsewhere(path.substr(path.rfind('.') + 1));
  if (hint.empty()) hint = fmt::format("; expected one of {}", fmt::join(full, ", "));
  fail(at, path, "unknown key" + hint);
}

/// Fills a scenario from a tree and from overrides, and notes where each value came from.
class Reader {
 public:
  ReadScenario result;

  void read_map(const Yaml& map, const std::string& section) {
    for (std::size_t i = 0; i < map.keys.size(); ++i) {
      const std::string& part = map.keys[i].text;
      read_entry(map.keys[i], section.empty() ? part : section + "." + part, map.items[i]);
    }
  }

  /// The file's stem names the scenario as long as no key does.
  void read_name_of_file(const Yaml& root, const std::string& file_name) {
    Yaml stem;
    stem.kind = Yaml::Kind::scalar;
    stem.text = std::filesystem::path(file_name).stem().string();
    stem.origin = {file_name};
    const bool named =
        std::any_of(root.keys.begin(), root.keys.end(), [](const Yaml& k) { return k.text == "name"; });
    if (!named) find_key("name")->read(stem, result.scenario);
  }

  /// "key=value", the n-th of the command line (from 1).
  void read_override(const std::string& argument, int n) {
    const std::size_t equals = argument.find('=');
    Yaml at;
    at.origin = {"<argument>", n, 1};
    if (equals == std::string::npos || equals == 0)
      fail(at, "", fmt::format("'{}': expected key=value", argument));
    const std::string key = argument.substr(0, equals);
    const Yaml value =
        parse_yaml(argument.substr(equals + 1), {"<argument>", n, static_cast<int>(equals) + 2});
    read_value(at, key, value, fmt::format("argument {}", n));
  }

 private:
  void read_entry(const Yaml& at, const std::string& path, const Yaml& value) {
    const bool section = is_section(path) || path.starts_with("limits.");
    if (find_key(path) == nullptr && section && value.kind == Yaml::Kind::map) {
      if (path.starts_with("limits.") && value.keys.empty())
        fail(at, path, "is empty, expected at_most or at_least");
      begin_section(path);
      read_map(value, path);
    } else {
      note_once(at, path);
      read_value(at, path, value, fmt::format("{}:{}", at.origin.file, at.origin.line));
    }
  }

  void begin_section(const std::string& path) {
    if (path == "camera" && !result.scenario.camera) result.scenario.camera.emplace();
    if (path == "slam" && !result.scenario.slam) result.scenario.slam.emplace();
  }

  /// `a.b: 1` and `a: {b: 2}` name the same key.
  void note_once(const Yaml& at, const std::string& path) {
    const auto [earlier, first] = result.origin.emplace(path, "");
    if (!first) fail(at, path, fmt::format("given twice, first at {}", earlier->second));
  }

  void read_value(const Yaml& at, const std::string& path, const Yaml& value, const std::string& origin) {
    const Key<Scenario>* const key = find_key(path);
    if (key == nullptr && path.starts_with("limits.")) {
      read_limit(at, path, value, result.scenario.limits.metrics);
    } else if (key == nullptr && is_section(path)) {
      fail(at, path,
           fmt::format("is a section, expected keys below it: {}", fmt::join(parts_below(path), ", ")));
    } else if (key == nullptr) {
      fail_unknown(at, path);
    } else {
      require_section(at, path);
      key->read(value.kind == Yaml::Kind::empty ? placed(value, at) : value, result.scenario);
    }
    result.origin[path] = origin;
  }

  void require_section(const Yaml& at, const std::string& path) {
    begin_section_of_dotted(at, path);
    if (has_section(result.scenario, path)) return;
    fail(at, path, fmt::format("this scenario has no section '{}'", path.substr(0, path.find('.'))));
  }

  /// In a file `slam.gyro.enabled: true` begins the section as `slam:` would; an argument does not.
  void begin_section_of_dotted(const Yaml& at, const std::string& path) {
    if (at.origin.file != "<argument>") begin_section(path.substr(0, path.find('.')));
  }

  static Yaml placed(Yaml value, const Yaml& at) {
    value.origin = at.origin;
    return value;
  }
};

void leave_out(Scenario& scenario, const std::vector<std::string>& without) {
  static constexpr std::string_view kSections[]{"camera", "slam"};
  for (std::size_t i = 0; i < without.size(); ++i) {
    if (without[i] == "camera") {
      scenario.camera.reset();
    } else if (without[i] == "slam") {
      scenario.slam.reset();
    } else {
      throw ConfigError(fmt::format("--without {}: expected camera or slam{}", without[i],
                                    did_you_mean(without[i], kSections)));
    }
  }
}

/// What no single key can know.
void check_whole(const Scenario& scenario, const Yaml& at) {
  if (scenario.walk.commands.empty()) {
    fail(at, "walk.commands", "missing, expected a list of commands, as in [{stand: {duration_s: 1}}]");
  }
  if (scenario.slam && !scenario.camera) {
    fail(at, "slam",
         "needs the section 'camera': the filter works at its frames (--without camera,slam drops both)");
  }
}

std::string read_file(const std::filesystem::path& file) {
  constexpr std::uintmax_t kLargest = 1 << 20;
  std::error_code fault;
  if (std::filesystem::is_directory(file, fault))
    throw ConfigError(fmt::format("{}: is a folder, expected a scenario file", file.string()));
  std::ifstream in(file, std::ios::binary);
  if (!in) throw ConfigError(fmt::format("{}: cannot be read: {}", file.string(), std::strerror(errno)));
  std::string text(kLargest + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kLargest)
    throw ConfigError(fmt::format("{}: larger than 1 MiB, expected a scenario", file.string()));
  return text;
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

ReadScenario read_scenario(const std::filesystem::path& file, const Changes& changes) {
  return read_scenario_text(read_file(file), file.string(), changes);
}

ReadScenario read_scenario_text(std::string_view text, const std::string& file_name, const Changes& changes) {
  const Yaml root = parse_yaml(text, {file_name});
  if (root.kind != Yaml::Kind::map) fail(root, "", "expected a scenario: keys and values, as in seed: 1");
  Reader reader;
  reader.read_name_of_file(root, file_name);
  reader.read_map(root, "");
  int n = 0;
  for (const std::string& argument : changes.overrides) reader.read_override(argument, ++n);
  leave_out(reader.result.scenario, changes.without);
  check_whole(reader.result.scenario, root);
  return reader.result;
}

std::string to_yaml(const Scenario& scenario) {
  YamlWriter yaml;
  for (const auto& key : scenario_keys()) {
    if (has_section(scenario, key.name)) yaml.write(key.name, key.print(scenario));
  }
  return yaml.text + print_limits(scenario.limits.metrics);
}

}  // namespace sim::bench
