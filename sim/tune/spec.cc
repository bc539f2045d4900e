#include "sim/tune/spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <span>

#include "sim/bench/scenario_keys.h"
#include "sim/bench/scenario_value.h"
#include "sim/tune/spec_yaml.h"

namespace sim::tune {
namespace {

using std::string_view_literals::operator""sv;
using bench::Domain;
using bench::Yaml;

constexpr std::array kObjectives{"pose_nll"sv, "innovation_nll"sv, "consistency"sv, "nis_consistency"sv,
                                 "rmse_m"sv};
constexpr std::array kOptimisers{"cma_es"sv, "differential_evolution"sv, "nsga_ii"sv};
constexpr std::array kScales{"log"sv, "linear"sv};
constexpr Domain kAnyNumber{-1e12, 1e12};

std::vector<std::string_view> tunable_keys() {
  std::vector<std::string_view> names;
  for (const auto& key : bench::scenario_keys())
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
  if (const auto* other = bench::find_key(key))
    fail(at, key, fmt::format("is {}, expected a key that is a number", other->expected));
  fail(at, key, "unknown key" + bench::did_you_mean(key, known));
}

// A number that the key itself accepts.
double read_bound(const Yaml& node, const std::string& key) {
  bench::Scenario scratch = bench::default_scenario();
  bench::find_key(key)->read(node, scratch);
  double value = 0;
  read(node, key, kAnyNumber, value);
  return value;
}

Parameter read_parameter(const Yaml& name, const Yaml& node) {
  require_tunable(name, name.text);
  require_map(node, name.text, "a range, as in {from: 0.001, to: 0.1}");
  Parameter p{name.text, {}, NAN, NAN, NAN, true};
  for_each_key(node, {"from", "to", "start", "scale", "also"}, [&](const Yaml& at, const Yaml& value) {
    if (at.text == "from") p.low = read_bound(value, p.key);
    if (at.text == "to") p.high = read_bound(value, p.key);
    if (at.text == "start") p.start = read_bound(value, p.key);
    if (at.text == "scale") p.logarithmic = read_choice(value, "scale", {0, 0, kScales}) == 0;
    if (at.text == "also") p.also = texts(value, "also");
    if (at.text == "also")
      for (const Yaml& item : value.items) require_tunable(item, item.text);
  });
  if (std::isnan(p.low) || std::isnan(p.high)) fail(node, p.key, "expected both from and to");
  if (!(p.low < p.high))
    fail(node, p.key, fmt::format("from {} to {}: expected a rising range", p.low, p.high));
  if (p.logarithmic && p.low <= 0)
    fail(node, p.key, "a range by the logarithm begins above 0; scale: linear has none such");
  if (!std::isnan(p.start) && (p.start < p.low || p.start > p.high))
    fail(node, p.key, fmt::format("start {} is outside {} to {}", p.start, p.low, p.high));
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

std::vector<Objective> read_objectives(const Yaml& node) {
  const Domain names{0, 0, kObjectives};
  std::vector<Objective> all;
  if (node.kind != Yaml::Kind::list) return {static_cast<Objective>(read_choice(node, "objective", names))};
  for (const Yaml& item : node.items)
    all.push_back(static_cast<Objective>(read_choice(item, "objective", names)));
  if (all.empty() || all.size() > 2 || (all.size() == 2 && all[0] == all[1]))
    fail(node, "objective", "expected one objective, or two different ones for their Pareto front");
  return all;
}

// Sections that the spec does not have stay empty; required ones are checked at the end.
Spec read_root(const Yaml& root, const std::filesystem::path& folder) {
  Spec spec;
  for_each_key(
      root,
      {"parameters", "training", "holdout", "objective", "optimiser", "trials", "polish", "population",
       "profiles", "restarts", "seed"},
      [&](const Yaml& at, const Yaml& value) {
        if (at.text == "parameters") spec.parameters = read_parameters(value);
        if (at.text == "training") spec.training = read_footage(value, "training", folder);
        if (at.text == "holdout") spec.holdout = read_footage(value, "holdout", folder);
        if (at.text == "objective") spec.objectives = read_objectives(value);
        if (at.text == "optimiser")
          spec.optimiser = static_cast<Optimiser>(read_choice(value, "optimiser", {0, 0, kOptimisers}));
        if (at.text == "trials") read(value, "trials", {2, 1e6}, spec.trials);
        if (at.text == "polish") read(value, "polish", {0, 1e6}, spec.polish);
        if (at.text == "population") read(value, "population", {5, 1000}, spec.population);
        if (at.text == "profiles") read(value, "profiles", {}, spec.profiles);
        if (at.text == "restarts") read(value, "restarts", {0, 100}, spec.restarts);
        if (at.text == "seed") read(value, "seed", {}, spec.seed);
      });
  return spec;
}

void require_whole(const Yaml& root, const Spec& spec) {
  if (spec.parameters.empty()) fail(root, "parameters", "missing, expected keys with their ranges");
  if (spec.training.empty())
    fail(root, "training", "missing, expected recordings, as in [{scenario: FILE, seeds: 1..4}]");
  if (spec.holdout.empty())
    fail(root, "holdout",
         "missing: without recordings that tuning has not seen nothing shows whether it helps");
  const bool front = spec.objectives.size() == 2;
  if (front != (spec.optimiser == Optimiser::nsga_ii))
    fail(root, "optimiser", front ? "two objectives need nsga_ii" : "nsga_ii needs two objectives");
  if (front && spec.population % 4 != 0)
    fail(root, "population", fmt::format("is {}, expected a multiple of 4 for nsga_ii", spec.population));
  if (spec.trials <= spec.population + spec.polish)
    fail(root, "trials",
         fmt::format("{} are too few for a population of {} and a polish of {}", spec.trials, spec.population,
                     spec.polish));
}

// What both begin with is the start of the search, where the spec does not name another.
void complete_starts(const Yaml& root, Spec& spec) {
  const Footage& first = spec.training.front();
  const bench::Scenario scenario = first_scenario_of(first).scenario;
  for (Parameter& p : spec.parameters) {
    if (!std::isnan(p.start)) continue;
    if (!bench::has_section(scenario, p.key)) fail(root, p.key, "the recorded scenario has no such section");
    p.start = std::stod(bench::find_key(p.key)->print(scenario));
    if (p.start < p.low || p.start > p.high)
      fail(root, p.key, fmt::format("starts at {}, outside {} to {}", p.start, p.low, p.high));
  }
}

}  // namespace

double Parameter::at(double part) const {
  if (part <= 0) return low;
  if (part >= 1) return high;
  return logarithmic ? low * std::exp(part * std::log(high / low)) : low + part * (high - low);
}

double Parameter::part_of(double value) const {
  const double part =
      logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
  return std::clamp(part, 0.0, 1.0);
}

std::span<const std::string_view> objective_names() { return kObjectives; }
std::string_view name(Objective objective) { return kObjectives[static_cast<std::size_t>(objective)]; }

Spec read_spec_text(std::string_view text, const std::string& file_name) {
  const Yaml root = bench::parse_yaml(text, {file_name});
  require_map(root, "", "a tuning: {parameters: ..., training: ..., holdout: ...}");
  const std::filesystem::path file = file_name;
  Spec spec = read_root(root, file.parent_path());
  spec.name = file.stem().string();
  require_whole(root, spec);
  complete_starts(root, spec);
  return spec;
}

Spec read_spec(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file))
    throw bench::ConfigError(
        fmt::format("{}: cannot be read: {}", file.string(), std::strerror(in ? EISDIR : errno)));
  return read_spec_text(std::string{std::istreambuf_iterator<char>(in), {}}, file.string());
}

void set(bench::Scenario& scenario, const std::string& key, double value) {
  Yaml node;
  node.kind = Yaml::Kind::scalar;
  node.text = fmt::format("{}", value);
  node.origin = {key};
  bench::find_key(key)->read(node, scenario);
}

}  // namespace sim::tune
