
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <span>

#include "sim/files/text.h"
#include "sim/scenario/keys.h"
#include "sim/scenario/limits.h"
#include "sim/scenario/scenario.h"

namespace sim::scenario {
namespace {

constexpr const char* kArgument = "<argument>";
constexpr int kMostBases = 100;  // a few files that name each other often would be read without end
constexpr const char* kCommands = "walk.commands";
constexpr const char* kBase = "base";  // not in the table of keys

/// Parts below `section` ("" for the top): "walk" -> {"single_support_s", ...}.
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

/// Suggests the key of another section that has this last part.
std::string suggest_elsewhere(std::string_view part) {
  for (const auto& key : scenario_keys()) {
    if (std::string_view(key.name).substr(key.name.rfind('.') + 1) == part) {
      return fmt::format("; did you mean '{}'?", key.name);
    }
  }
  return "";
}

/// Names the longest known section of the path and its parts.
[[noreturn]] void fail_unknown(const Yaml& at, const std::string& path) {
  if (const std::string former = former_name(path); !former.empty()) fail(at, path, former);
  std::string section = path;
  do {
    const std::size_t dot = section.rfind('.');
    section.resize(dot == std::string::npos ? 0 : dot);
  } while (!section.empty() && !is_section(section));
  std::vector<std::string_view> known = parts_below(section);
  if (section.empty()) known.insert(known.begin(), kBase);
  const std::string prefix = section.empty() ? "" : section + ".";
  std::vector<std::string> full;
  for (const std::string_view name : known) full.push_back(prefix + std::string(name));
  const std::vector<std::string_view> candidates(full.begin(), full.end());
  std::string hint = did_you_mean(path, candidates);
  if (hint.empty()) hint = suggest_elsewhere(path.substr(path.rfind('.') + 1));
  if (hint.empty()) hint = fmt::format("; expected one of {}", fmt::join(full, ", "));
  fail(at, path, "unknown key" + hint);
}

bool same_file(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code fault;
  return a == b || std::filesystem::equivalent(a, b, fault);
}

/// Fills a scenario from the trees of files and from overrides; later values replace earlier ones. All
/// members throw ConfigError.
class ScenarioReader {
 public:
  ReadScenario result;

  /// Reads all keys of a file, after those of its bases. root.origin.file: its path.
  void read_file(const Yaml& root);

  /// Names the scenario after the file, unless it has a key `name`; the name of a base is not inherited.
  void read_name_of_file(const Yaml& root, const std::string& file_name);

  /// "key=value" or "section={key: value}", the n-th of the command line (from 1).
  void read_override(const std::string& argument, int n);

 private:
  void read_bases(const Yaml& root);
  void read_base(const Yaml& node);
  void read_map(const Yaml& map, const std::string& section);
  void read_entry(const Yaml& at, const std::string& path, const Yaml& value);
  void read_value(const Yaml& at, const std::string& path, const Yaml& value);
  void note_commands(const Yaml& commands);
  void note_once(const Yaml& at, const std::string& path);
  void begin_section(std::string_view path);
  void require_section(const Yaml& at, const std::string& path);

  std::vector<std::filesystem::path> open_files_;  // each but the first is a base of the one before
  int bases_read_ = 0;
  std::map<std::string, std::string> given_;  // keys of the file at hand, and where
};

void leave_out(Scenario& scenario, const std::vector<std::string>& without) {
  static constexpr std::string_view kSections[]{"camera", "slam"};
  for (std::size_t i = 0; i < without.size(); ++i) {
    if (without[i] == "camera") {
      scenario.camera.reset();
      scenario.world.lights_off = {};
      std::erase_if(scenario.errors.faults,
                    [](const auto& fault) { return !sensor_errors::is_of_steering(fault); });
    } else if (without[i] == "slam") {
      scenario.slam.reset();
    } else {
      throw ConfigError(fmt::format("--without {}: expected camera or slam{}", without[i],
                                    did_you_mean(without[i], kSections)));
    }
  }
}

}  // namespace

std::string file_text(const std::filesystem::path& file) {
  std::error_code fault;
  if (std::filesystem::is_directory(file, fault))
    throw ConfigError(fmt::format("{}: is a folder, expected a scenario file", file.string()));
  try {
    return files::read_text(file, files::kMostOfYaml);
  } catch (const files::FileError& e) {
    throw ConfigError(e.what());
  }
}

void ScenarioReader::read_file(const Yaml& root) {
  if (root.kind != Yaml::Kind::map)
    fail(root, "", "expected keys and values, as in slam.gyro.sigma_rad_s: 0.01");
  open_files_.push_back(root.origin.file);
  read_bases(root);
  open_files_.pop_back();
  given_.clear();
  read_map(root, "");
}

void ScenarioReader::read_bases(const Yaml& root) {
  const auto key =
      std::find_if(root.keys.begin(), root.keys.end(), [](const Yaml& k) { return k.text == kBase; });
  if (key == root.keys.end()) return;
  const Yaml& value = root.items[static_cast<std::size_t>(key - root.keys.begin())];
  const bool list = value.kind == Yaml::Kind::list && !value.items.empty();
  for (const Yaml& node : list ? std::span(value.items) : std::span(&value, 1)) read_base(node);
}

void ScenarioReader::read_base(const Yaml& node) {
  if (node.kind != Yaml::Kind::scalar || node.text.empty())
    fail(node, kBase, "expected a scenario file or a list of them, as in base: tangent_circle.yaml");
  if (++bases_read_ > kMostBases)
    fail(node, kBase, fmt::format("more than {} files in all, those of bases included", kMostBases));
  const auto file = (std::filesystem::path(node.origin.file).parent_path() / node.text).lexically_normal();
  for (const auto& open : open_files_)
    if (same_file(open, file))
      fail(node, kBase,
           fmt::format("{} is a base of itself, by way of {}", file.string(), open_files_.back().string()));
  std::string text;
  try {
    text = file_text(file);
  } catch (const ConfigError& e) {
    fail(node, kBase, e.what());
  }
  read_file(parse_yaml(text, {file.string()}));
}

void ScenarioReader::read_name_of_file(const Yaml& root, const std::string& file_name) {
  const bool named =
      std::any_of(root.keys.begin(), root.keys.end(), [](const Yaml& key) { return key.text == "name"; });
  if (named) return;
  Yaml stem;
  stem.kind = Yaml::Kind::scalar;
  stem.text = std::filesystem::path(file_name).stem().string();
  stem.origin = {file_name};
  find_key("name")->read(stem, result.scenario);
  result.origin.erase("name");
}

void ScenarioReader::read_map(const Yaml& map, const std::string& section) {
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const std::string& part = map.keys[i].text;
    if (section.empty() && part == kBase) continue;  // read_bases has read it
    read_entry(map.keys[i], section.empty() ? part : section + "." + part, map.items[i]);
  }
}

void ScenarioReader::read_override(const std::string& argument, int n) {
  const std::size_t equals = argument.find('=');
  Yaml at;
  at.origin = {kArgument, n, 1};
  if (equals == std::string::npos || equals == 0)
    fail(at, "", fmt::format("'{}': expected key=value", argument));
  const Yaml value = parse_yaml(argument.substr(equals + 1), {kArgument, n, static_cast<int>(equals) + 2});
  given_.clear();  // a later argument replaces an earlier one
  read_entry(at, argument.substr(0, equals), value);
}

void ScenarioReader::read_entry(const Yaml& at, const std::string& path, const Yaml& value) {
  const bool limit = path.starts_with("limits.");
  const bool section = find_key(path) == nullptr && (limit || is_section(path));
  if (section && value.kind == Yaml::Kind::map) {
    if (limit && value.keys.empty()) fail(at, path, "is empty, expected at_most or at_least");
    if (!limit) require_section(at, path);
    read_map(value, path);
  } else {
    note_once(at, path);
    read_value(at, path, value);
  }
}

void ScenarioReader::read_value(const Yaml& at, const std::string& path, const Yaml& value) {
  if (const Key* const key = find_key(path)) {
    require_section(at, path);
    Yaml placed = value;
    if (value.kind == Yaml::Kind::empty) placed.origin = at.origin;
    key->read(placed, result.scenario);
    if (path == kCommands) note_commands(placed);
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
  result.origin[path] = at.origin.file == kArgument ? fmt::format("argument {}", at.origin.line)
                                                    : fmt::format("{}:{}", at.origin.file, at.origin.line);
}

void ScenarioReader::note_commands(const Yaml& commands) {
  result.command_origins.clear();
  for (const Yaml& command : commands.items) result.command_origins.push_back(command.origin);
}

// `a.b: 1` and `a: {b: 2}` name the same key.
void ScenarioReader::note_once(const Yaml& at, const std::string& path) {
  const auto [earlier, first] = given_.emplace(path, fmt::format("{}:{}", at.origin.file, at.origin.line));
  if (!first) fail(at, path, fmt::format("given twice, first at {}", earlier->second));
}

void ScenarioReader::begin_section(std::string_view path) {
  if (path == "camera" && !result.scenario.camera) result.scenario.camera.emplace();
  if (path == "slam" && !result.scenario.slam) result.scenario.slam.emplace();
}

// In a file `slam.gyro.enabled: true` starts the section as `slam:` would; an argument does not.
void ScenarioReader::require_section(const Yaml& at, const std::string& path) {
  const std::string section = path.substr(0, path.find('.'));
  if (at.origin.file != kArgument) begin_section(section);
  if (!has_section(result.scenario, path)) {
    fail(at, path, fmt::format("this scenario has no section '{}'", section));
  }
}

ReadScenario read_scenario(const std::filesystem::path& file, const Changes& changes) {
  return read_scenario_text(file_text(file), file.string(), changes);
}

ReadScenario read_scenario_text(std::string_view text, const std::string& file_name, const Changes& changes) {
  const Yaml root = parse_yaml(text, {file_name});
  if (root.kind != Yaml::Kind::map) fail(root, "", "expected a scenario: keys and values, as in seed: 1");
  ScenarioReader reader;
  reader.read_file(root);
  reader.read_name_of_file(root, file_name);
  for (const std::string& overlay : changes.with) reader.read_file(parse_yaml(file_text(overlay), {overlay}));
  int n = 0;
  for (const std::string& argument : changes.overrides) reader.read_override(argument, ++n);
  leave_out(reader.result.scenario, changes.without);
  check_whole(reader.result, root);
  return reader.result;
}

}  // namespace sim::scenario
