#include "sim/regression/suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "sim/scenario/limits.h"
#include "sim/scenario/value.h"
#include "sim/scenario/yaml.h"
#include "sim/score/metrics.h"

namespace sim::regression {
namespace {

using scenario::fail;
using scenario::Yaml;
using std::string_view_literals::operator""sv;

constexpr scenario::Domain kTolerance{0, 1e6};
constexpr std::array kSections{"camera"sv, "slam"sv};

Gate read_gate(const Yaml& name, const Yaml& tolerance) {
  const std::string key = "gate." + name.text;
  if (!score::find_metric(name.text)) fail(name, key, scenario::unknown_metric(name.text));
  Gate gate{name.text};
  require_map(tolerance, key, "a tolerance, as in {percent: 10} or {absolute: 0.002}");
  const auto number = [&](const char* part, double& into) {
    return std::pair{std::string_view(part), [&into, key, part](const Yaml& value) {
                       read(value, key + "." + part, kTolerance, into);
                     }};
  };
  read_map(tolerance, {number("percent", gate.percent), number("absolute", gate.absolute)});
  return gate;
}

std::vector<Gate> read_gates(const Yaml& node) {
  require_map(node, "gate", "metrics with tolerances, as in {ate_se3_rmse_m: {percent: 10}}");
  std::vector<Gate> gates;
  for (std::size_t i = 0; i < node.keys.size(); ++i) gates.push_back(read_gate(node.keys[i], node.items[i]));
  if (gates.empty() || gates.size() > kMostGates)
    fail(node, "gate", fmt::format("has {} metrics, expected 1 to {}", gates.size(), kMostGates));
  return gates;
}

std::vector<std::string> read_without(const Yaml& node) {
  std::vector<std::string> sections = read_texts(node, "without", "[slam]");
  for (std::size_t i = 0; i < sections.size(); ++i)
    if (std::find(kSections.begin(), kSections.end(), sections[i]) == kSections.end())
      fail(node.items[i], "without",
           fmt::format("'{}', expected camera or slam{}", sections[i],
                       scenario::did_you_mean(sections[i], kSections)));
  return sections;
}

SuiteEntry read_entry(const Yaml& node, const std::filesystem::path& folder) {
  require_map(node, "scenarios", "an entry, as in {scenario: ../tangent_circle.yaml}");
  SuiteEntry entry{{}, {}, default_gates()};
  read_map(node, {{"scenario", [&](const Yaml& value) { entry.file = read_path(value, "scenario", folder); }},
                  {"set",
                   [&](const Yaml& value) {
                     entry.changes.overrides = read_texts(value, "set", "[seed=1]");
                     entry.set = value.items;
                   }},
                  {"without", [&](const Yaml& value) { entry.changes.without = read_without(value); }},
                  {"gate", [&](const Yaml& value) { entry.gates = read_gates(value); }}});
  if (entry.file.empty()) fail(node, "scenario", "missing, expected a scenario's YAML file");
  return entry;
}

// An error in `set`, "<argument>:n:column: why", is reported at its place in the suite.
std::string name_of(const SuiteEntry& entry) {
  try {
    return scenario::read_scenario(entry.file, entry.changes).scenario.name;
  } catch (const scenario::ConfigError& e) {
    std::size_t n = 0;
    int column = 0, begin = 0;
    if (std::sscanf(e.what(), "<argument>:%zu:%d: %n", &n, &column, &begin) != 2) throw;
    Yaml at = entry.set.at(std::min(n, entry.set.size()) - 1);  // a text may have several lines
    at.origin.column += column - 1;
    fail(at, "set", e.what() + begin);
  }
}

void require_different_names(const Suite& suite, const std::filesystem::path& file) {
  std::vector<std::string> names;
  for (const SuiteEntry& entry : suite.entries) {
    const std::string name = name_of(entry);
    if (std::find(names.begin(), names.end(), name) != names.end())
      throw scenario::ConfigError(
          fmt::format("{}: two scenarios are called '{}'; set: [name=...] renames one", file.string(), name));
    names.push_back(name);
  }
}

}  // namespace

bool is_suite(const std::filesystem::path& file) {
  const Yaml root = scenario::parse_yaml_file(file);
  return std::ranges::any_of(root.keys, [](const Yaml& key) { return key.text == "scenarios"; });
}

Suite read_suite(const std::filesystem::path& file) {
  const Yaml root = scenario::parse_yaml_file(file);
  require_map(root, "", "a suite: {seeds: 1..3, scenarios: [{scenario: FILE}]}");
  Suite suite{file.stem().string(), "", {}};
  read_map(root, {{"seeds",
                   [&](const Yaml& value) {
                     read_seeds(value);
                     suite.seeds = value.text;
                   }},
                  {"scenarios", [&](const Yaml& value) {
                     if (value.kind != Yaml::Kind::list)
                       fail(value, "scenarios", "expected a list of scenarios");
                     for (const Yaml& entry : value.items)
                       suite.entries.push_back(read_entry(entry, file.parent_path()));
                   }}});
  if (suite.seeds.empty()) fail(root, "seeds", "missing, expected seeds, as in 1..3");
  if (suite.entries.empty()) fail(root, "scenarios", "the suite is empty, expected at least one scenario");
  require_different_names(suite, file);
  return suite;
}

}  // namespace sim::regression
