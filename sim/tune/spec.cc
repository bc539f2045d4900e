#include "sim/tune/spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/scenario/keys.h"
#include "sim/scenario/value.h"
#include "sim/tune/yaml_map.h"

namespace sim::tune {
namespace {

using std::string_view_literals::operator""sv;
using scenario::Domain;
using scenario::shapes_recording;
using scenario::Yaml;

constexpr std::array kObjectives{"pose_nll"sv, "innovation_nll"sv, "consistency"sv, "nis_consistency"sv,
                                 "rmse_m"sv};
constexpr std::array kScales{"log"sv, "linear"sv};
constexpr Domain kAnyNumber{-1e12, 1e12};

std::vector<std::string_view> tunable_keys() {
  std::vector<std::string_view> names;
  for (const auto& key : scenario::scenario_keys())
    if (!shapes_recording(key.name) && key.name != "name" && key.name != "seed" &&
        key.expected.starts_with("a number"))
      names.push_back(key.name);
  return names;
}

void require_tunable(const Yaml& at, const std::string& key) {
  const std::vector<std::string_view> known = tunable_keys();
  if (std::find(known.begin(), known.end(), key) != known.end()) return;
  if (shapes_recording(key) || key == "name" || key == "seed")
    fail(at, key, "shapes the recording, which tuning does not change");
  if (const auto* other = scenario::find_key(key))
    fail(at, key, fmt::format("is {}, expected a key that is a number", other->expected));
  fail(at, key, "unknown key" + scenario::did_you_mean(key, known));
}

// A number that the key itself accepts.
double read_bound(const Yaml& node, const std::string& key) {
  scenario::Scenario scratch = scenario::default_scenario();
  scenario::find_key(key)->read(node, scratch);
  double value = 0;
  read(node, key, kAnyNumber, value);
  return value;
}

std::vector<std::string> read_keys(const Yaml& node) {
  std::vector<std::string> keys = read_texts(node, "also");
  for (const Yaml& item : node.items) require_tunable(item, item.text);
  return keys;
}

void require_range(const Yaml& node, const Parameter& p) {
  if (std::isnan(p.low) || std::isnan(p.high)) fail(node, p.key, "expected both from and to");
  if (!(p.low < p.high))
    fail(node, p.key, fmt::format("from {} to {}: expected a rising range", p.low, p.high));
  if (p.logarithmic && p.low <= 0)
    fail(node, p.key, "a logarithmic range must begin above 0; scale: linear allows 0 and below");
  if (!std::isnan(p.start) && (p.start < p.low || p.start > p.high))
    fail(node, p.key, fmt::format("start {} is outside {} to {}", p.start, p.low, p.high));
}

Parameter read_parameter(const Yaml& name, const Yaml& node) {
  require_tunable(name, name.text);
  require_map(node, name.text, "a range, as in {from: 0.001, to: 0.1}");
  Parameter p{name.text, {}, NAN, NAN, NAN, true};
  read_map(node, {{"from", [&](const Yaml& value) { p.low = read_bound(value, p.key); }},
                  {"to", [&](const Yaml& value) { p.high = read_bound(value, p.key); }},
                  {"start", [&](const Yaml& value) { p.start = read_bound(value, p.key); }},
                  {"scale",
                   [&](const Yaml& value) {
                     p.logarithmic = read_choice(value, "scale", {0, 0, kScales}) == 0;
                   }},
                  {"also", [&](const Yaml& value) { p.also = read_keys(value); }}});
  require_range(node, p);
  return p;
}

std::vector<Parameter> read_parameters(const Yaml& node) {
  require_map(node, "parameters", "keys with ranges, as in {slam.gyro.sigma_rad_s: {from: 0.001, to: 0.1}}");
  std::vector<Parameter> all;
  for (std::size_t i = 0; i < node.keys.size(); ++i)
    all.push_back(read_parameter(node.keys[i], node.items[i]));
  if (all.empty()) fail(node, "parameters", "is empty, expected at least one key with its range");
  return all;
}

// Sections that the spec does not have stay empty; required ones are checked at the end.
Spec read_root(const Yaml& root, const std::filesystem::path& folder) {
  Spec spec;
  const auto number = [](const char* key, const Domain& domain, auto& value) {
    return std::pair{std::string_view(key),
                     [=, &value](const Yaml& node) { read(node, key, domain, value); }};
  };
  read_map(
      root,
      {{"parameters", [&](const Yaml& value) { spec.parameters = read_parameters(value); }},
       {"training",
        [&](const Yaml& value) { spec.training = read_recording_sets(value, "training", folder); }},
       {"holdout", [&](const Yaml& value) { spec.holdout = read_recording_sets(value, "holdout", folder); }},
       number("objective", {0, 0, kObjectives}, spec.objective),
       number("trials", {2, 1e6}, spec.trials),
       number("polish", {0, 1e6}, spec.polish),
       number("population", {5, 1000}, spec.population),
       number("profiles", {}, spec.profiles),
       number("restarts", {0, 100}, spec.restarts),
       number("seed", {}, spec.seed)});
  return spec;
}

void require_whole(const Yaml& root, const Spec& spec) {
  if (spec.parameters.empty()) fail(root, "parameters", "missing, expected keys with their ranges");
  if (spec.training.empty())
    fail(root, "training", "missing, expected recordings, as in [{scenario: FILE, seeds: 1..4}]");
  if (spec.holdout.empty())
    fail(root, "holdout",
         "missing, expected recordings that the search does not see, which show whether tuning helps");
  if (spec.trials <= spec.population + spec.polish)
    fail(root, "trials",
         fmt::format("{} are too few for a population of {} and a polish of {}", spec.trials, spec.population,
                     spec.polish));
}

// A parameter without a start begins at the value of the first training recording's scenario.
void complete_starts(const Yaml& root, Spec& spec) {
  const scenario::Scenario scenario = first_scenario_of(spec.training.front()).scenario;
  for (Parameter& p : spec.parameters) {
    if (!std::isnan(p.start)) continue;
    if (!scenario::has_section(scenario, p.key))
      fail(root, p.key, "the recorded scenario has no such section");
    p.start = std::stod(scenario::find_key(p.key)->print(scenario));
    if (p.start < p.low || p.start > p.high)
      fail(root, p.key, fmt::format("starts at {}, outside {} to {}", p.start, p.low, p.high));
  }
}

}  // namespace

double Parameter::value_at(double coordinate) const {
  if (coordinate <= 0) return low;
  if (coordinate >= 1) return high;
  return logarithmic ? low * std::exp(coordinate * std::log(high / low)) : low + coordinate * (high - low);
}

double Parameter::coordinate_of(double value) const {
  const double coordinate =
      logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
  return std::clamp(coordinate, 0.0, 1.0);
}

std::string_view name(Objective objective) { return kObjectives[static_cast<std::size_t>(objective)]; }

Spec read_spec(const std::filesystem::path& file) {
  const Yaml root = parse_yaml_file(file);
  require_map(root, "", "a tuning: {parameters: ..., training: ..., holdout: ...}");
  Spec spec = read_root(root, file.parent_path());
  spec.name = file.stem().string();
  require_whole(root, spec);
  complete_starts(root, spec);
  return spec;
}

void set(scenario::Scenario& scenario, const std::string& key, double value) {
  Yaml node;
  node.kind = Yaml::Kind::scalar;
  node.text = fmt::format("{}", value);
  node.origin = {key};
  scenario::find_key(key)->read(node, scenario);
}

}  // namespace sim::tune
