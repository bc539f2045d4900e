#include "sim/regression/suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "sim/files/text.h"
#include "sim/scenario/keys.h"
#include "sim/scenario/value.h"
#include "sim/scenario/yaml.h"
#include "sim/score/metrics.h"

namespace sim::regression {
namespace {

using std::string_view_literals::operator""sv;
constexpr scenario::Domain kTolerance{0, 1e6};

[[noreturn]] void unknown_key(const scenario::Yaml& at, std::span<const std::string_view> known) {
  scenario::fail(at, at.text, "unknown key" + scenario::did_you_mean(at.text, known));
}

void require_map(const scenario::Yaml& node, std::string_view key, std::string_view example) {
  if (node.kind != scenario::Yaml::Kind::map) scenario::fail(node, key, fmt::format("expected {}", example));
}

Gate read_gate(const scenario::Yaml& name, const scenario::Yaml& tolerance) {
  static constexpr std::array kKeys{"percent"sv, "absolute"sv};
  const std::string key = "gate." + name.text;
  if (!score::find_metric(name.text)) {
    std::vector<std::string_view> names;
    for (const auto& metric : score::metric_definitions()) names.push_back(metric.name);
    scenario::fail(name, key,
                   fmt::format("unknown metric '{}'{}", name.text, scenario::did_you_mean(name.text, names)));
  }
  Gate gate{name.text};
  require_map(tolerance, key, "a tolerance, as in {percent: 10} or {absolute: 0.002}");
  for (std::size_t i = 0; i < tolerance.keys.size(); ++i) {
    const scenario::Yaml& at = tolerance.keys[i];
    if (at.text != kKeys[0] && at.text != kKeys[1]) unknown_key(at, kKeys);
    read(tolerance.items[i], key + "." + at.text, kTolerance,
         at.text == kKeys[0] ? gate.percent : gate.absolute);
  }
  return gate;
}

std::vector<Gate> read_gates(const scenario::Yaml& node) {
  require_map(node, "gate", "metrics with tolerances, as in {ate_se3_rmse_m: {percent: 10}}");
  std::vector<Gate> gates;
  for (std::size_t i = 0; i < node.keys.size(); ++i) gates.push_back(read_gate(node.keys[i], node.items[i]));
  if (gates.empty() || gates.size() > kMostGates)
    scenario::fail(node, "gate", fmt::format("has {} metrics, expected 1 to {}", gates.size(), kMostGates));
  return gates;
}

std::vector<std::string> texts(const scenario::Yaml& node, const std::string& key, std::string_view example) {
  if (node.kind != scenario::Yaml::Kind::list)
    scenario::fail(node, key, fmt::format("expected a list, as in {}", example));
  std::vector<std::string> all;
  for (const scenario::Yaml& item : node.items) {
    if (item.kind != scenario::Yaml::Kind::scalar)
      scenario::fail(item, key, fmt::format("expected text, as in {}", example));
    all.push_back(item.text);
  }
  return all;
}

std::vector<std::string> read_without(const scenario::Yaml& node) {
  static constexpr std::array kSections{"camera"sv, "slam"sv};
  std::vector<std::string> sections = texts(node, "without", "[slam]");
  for (std::size_t i = 0; i < sections.size(); ++i)
    if (std::find(kSections.begin(), kSections.end(), sections[i]) == kSections.end())
      scenario::fail(node.items[i], "without",
                     fmt::format("'{}', expected camera or slam{}", sections[i],
                                 scenario::did_you_mean(sections[i], kSections)));
  return sections;
}

SuiteEntry read_entry(const scenario::Yaml& node, const std::filesystem::path& folder) {
  static constexpr std::array kKeys{"scenario"sv, "set"sv, "without"sv, "gate"sv};
  require_map(node, "scenarios", "an entry, as in {scenario: ../tangent_circle.yaml}");
  SuiteEntry entry{{}, {}, default_gates()};
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    const std::string& key = node.keys[i].text;
    if (key == "scenario") {
      if (node.items[i].kind != scenario::Yaml::Kind::scalar)
        scenario::fail(node.items[i], key, "expected a scenario's YAML file");
      entry.file = (folder / node.items[i].text).lexically_normal();
    } else if (key == "set") {
      entry.changes.overrides = texts(node.items[i], key, "[seed=1]");
      entry.set = node.items[i].items;
    } else if (key == "without") {
      entry.changes.without = read_without(node.items[i]);
    } else if (key == "gate") {
      entry.gates = read_gates(node.items[i]);
    } else {
      unknown_key(node.keys[i], kKeys);
    }
  }
  if (entry.file.empty()) scenario::fail(node, "scenario", "missing, expected a scenario's YAML file");
  return entry;
}

// An error in what the suite sets, "<argument>:n:column: why", is reported as one of the suite, at its place.
std::string name_of(const SuiteEntry& entry) {
  try {
    return scenario::read_scenario(entry.file, entry.changes).scenario.name;
  } catch (const scenario::ConfigError& e) {
    std::size_t n = 0;
    int column = 0, begin = 0;
    if (std::sscanf(e.what(), "<argument>:%zu:%d: %n", &n, &column, &begin) != 2) throw;
    scenario::Yaml at = entry.set.at(std::min(n, entry.set.size()) - 1);  // a text may have several lines
    at.origin.column += column - 1;
    scenario::fail(at, "set", e.what() + begin);
  }
}

void require_different_names(const Suite& suite, const std::filesystem::path& file) {
  std::vector<std::string> names;
  for (const SuiteEntry& entry : suite.entries) {
    const std::string name = name_of(entry);
    if (std::find(names.begin(), names.end(), name) != names.end())
      throw scenario::ConfigError(fmt::format(
          "{}: two scenarios are called '{}'; set: [name=...] tells them apart", file.string(), name));
    names.push_back(name);
  }
}

}  // namespace

Suite read_suite(const std::filesystem::path& file) {
  static constexpr std::array kKeys{"seeds"sv, "scenarios"sv};
  const scenario::Yaml root =
      scenario::parse_yaml(files::read_text(file, files::kMostOfYaml), {file.string()});
  require_map(root, "", "a suite: {seeds: 1..3, scenarios: [{scenario: FILE}]}");
  Suite suite{file.stem().string(), "", {}};
  for (std::size_t i = 0; i < root.keys.size(); ++i) {
    const scenario::Yaml& value = root.items[i];
    if (root.keys[i].text == "seeds") {
      if (value.kind != scenario::Yaml::Kind::scalar)
        scenario::fail(value, "seeds", "expected seeds, as in 1..3");
      suite.seeds = value.text;
    } else if (root.keys[i].text == "scenarios") {
      if (value.kind != scenario::Yaml::Kind::list)
        scenario::fail(value, "scenarios", "expected a list of scenarios");
      for (const scenario::Yaml& entry : value.items)
        suite.entries.push_back(read_entry(entry, file.parent_path()));
    } else {
      unknown_key(root.keys[i], kKeys);
    }
  }
  if (suite.seeds.empty()) scenario::fail(root, "seeds", "missing, expected seeds, as in 1..3");
  if (suite.entries.empty())
    scenario::fail(root, "scenarios", "the suite is empty, expected at least one scenario");
  require_different_names(suite, file);
  return suite;
}

std::map<std::string, std::string> config_of(const scenario::ReadScenario& read) {
  std::map<std::string, std::string> config;
  if (read.scenario.camera) config["camera"] = "present";
  if (read.scenario.slam) config["slam"] = "present";
  for (const auto& [name, origin] : read.origin) {
    const scenario::Key* key = scenario::find_key(name);
    if (name == "name" || name == "seed" || name.starts_with("limits.") || !key) continue;
    if (scenario::has_section(read.scenario, name)) config[name] = key->print(read.scenario);
  }
  return config;
}

}  // namespace sim::regression
