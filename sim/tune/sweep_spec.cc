#include "sim/tune/sweep_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/scenario/keys.h"
#include "sim/tune/samples.h"
#include "sim/tune/value_list.h"
#include "sim/tune/yaml_map.h"

namespace sim::tune {
namespace {

using scenario::Yaml;
using std::string_view_literals::operator""sv;
namespace fs = std::filesystem;

constexpr std::array kMethods{"sobol"sv, "random"sv};
constexpr const char* kArgument = "<argument>";

/// Keys of scenarios that a sweep can set.
void require_key(const Yaml& at, const std::string& key) {
  if (key == "seed") scenario::fail(at, key, "is no key of a sweep, expected seeds (--seeds 1..5)");
  if (key == "name" || key.starts_with("limits."))
    scenario::fail(at, key, "does not change a run, expected a key that does");
  if (scenario::find_key(key)) return;
  std::vector<std::string_view> names;
  for (const auto& known : scenario::scenario_keys()) names.push_back(known.name);
  scenario::fail(at, key, "unknown key" + scenario::did_you_mean(key, names));
}

void require_entries(const Yaml& node, std::string_view key, std::string_view example) {
  require_map(node, key, example);
  if (node.keys.empty()) scenario::fail(node, key, fmt::format("is empty, expected {}", example));
}

Axis grid_axis(const Yaml& key, const Yaml& values) {
  require_key(key, key.text);
  Axis axis;
  for (Yaml& value : values_of_list(values)) axis.push_back({{key.text, key, std::move(value)}});
  if (axis.empty()) scenario::fail(values, key.text, "has no values");
  return axis;
}

/// Throws ConfigError at the key of the axis by which there are more combinations than a sweep may have.
void add_axis(std::vector<Axis>& axes, Axis axis) {
  const Setting& first = axis.front().front();
  std::size_t n = axis.size();
  for (const Axis& before : axes) n *= before.size();
  if (n > kMostTrials)
    scenario::fail(first.at, first.key,
                   fmt::format("makes {} combinations, expected at most {}", n, kMostTrials));
  axes.push_back(std::move(axis));
}

/// Sets the keys together: point i has the i-th value of each key.
Axis zip_axis(const std::vector<Yaml>& keys, const std::vector<Yaml>& values) {
  Axis axis = grid_axis(keys[0], values[0]);
  for (std::size_t k = 1; k < keys.size(); ++k) {
    const Axis other = grid_axis(keys[k], values[k]);
    if (other.size() != axis.size())
      scenario::fail(values[k], keys[k].text,
                     fmt::format("has {} values, and {} has {}: zip needs as many of each", other.size(),
                                 keys[0].text, axis.size()));
    for (std::size_t i = 0; i < axis.size(); ++i) axis[i].push_back(other[i][0]);
  }
  return axis;
}

/// A key and what its samples are drawn from.
struct Distribution {
  Yaml key;
  bool logarithmic = false;
  double lowest = 0, highest = 0;
};

bool is_distribution(const Yaml& value) {
  const auto call = call_of(value);
  return call && (call->name == "uniform" || call->name == "loguniform");
}

Distribution distribution(const Yaml& key, const Yaml& value) {
  require_key(key, key.text);
  if (!is_distribution(value))
    scenario::fail(value, key.text, "expected uniform(lowest, highest) or loguniform(lowest, highest)");
  const Call call = *call_of(value);
  Distribution d{key, call.name == "loguniform", 0, 0};
  if (call.arguments.size() != 2)
    scenario::fail(value, key.text,
                   fmt::format("{}(...): has {} numbers, expected 2", call.name, call.arguments.size()));
  d.lowest = call.arguments[0], d.highest = call.arguments[1];
  if (!(d.lowest < d.highest))
    scenario::fail(value, key.text, fmt::format("{} is not below {}", d.lowest, d.highest));
  if (d.logarithmic && d.lowest <= 0) scenario::fail(value, key.text, "loguniform needs bounds above 0");
  return d;
}

double at(const Distribution& d, double part) {
  if (!d.logarithmic) return d.lowest + part * (d.highest - d.lowest);
  const double lowest = std::log10(d.lowest), highest = std::log10(d.highest);
  return std::pow(10, lowest + part * (highest - lowest));
}

Axis sample_axis(const std::vector<Distribution>& distributions, const Sampling& sampling) {
  const bool sobol = sampling.method == "sobol";
  if (sobol && distributions.size() > kMostSobolDimensions)
    scenario::fail(
        distributions.back().key, distributions.back().key.text,
        fmt::format("sobol samples have at most {} keys; random ones have any number", kMostSobolDimensions));
  const auto n = static_cast<std::size_t>(sampling.points);
  const auto points = sobol ? sobol_points(n, distributions.size(), sampling.seed)
                            : random_points(n, distributions.size(), sampling.seed);
  Axis axis(n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t d = 0; d < distributions.size(); ++d) {
      const Yaml& key = distributions[d].key;
      axis[i].push_back({key.text, key, number_node(at(distributions[d], points[i][d]), key.origin)});
    }
  return axis;
}

Axis read_sample(const Yaml& node) {
  constexpr const char* kExample = "keys with uniform(a, b) or loguniform(a, b)";
  require_entries(node, "sample", "a map, as in {points: 32, keys: {slam.vision.sigma_px: 'uniform(1, 3)'}}");
  Sampling sampling;
  std::vector<Distribution> distributions;
  const auto read_distributions = [&](const Yaml& value) {
    require_entries(value, "sample.keys", kExample);
    for (std::size_t k = 0; k < value.keys.size(); ++k)
      distributions.push_back(distribution(value.keys[k], value.items[k]));
  };
  read_map(node,
           {{"method",
             [&](const Yaml& value) {
               sampling.method = kMethods[scenario::read_choice(value, "sample.method", {0, 0, kMethods})];
             }},
            {"points",
             [&](const Yaml& value) {
               scenario::read(value, "sample.points", {1, kMostTrials}, sampling.points);
             }},
            {"seed", [&](const Yaml& value) { scenario::read(value, "sample.seed", {}, sampling.seed); }},
            {"keys", read_distributions}});
  if (distributions.empty())
    scenario::fail(node, "sample.keys", fmt::format("missing, expected {}", kExample));
  return sample_axis(distributions, sampling);
}

void read_zip(const Yaml& node, std::vector<Axis>& axes) {
  if (node.kind == Yaml::Kind::list) {
    for (const Yaml& item : node.items) read_zip(item, axes);
    return;
  }
  require_entries(node, "zip", "keys with lists of values that are set together, or a list of such maps");
  add_axis(axes, zip_axis(node.keys, node.items));
}

fs::path scenario_file(const Yaml& node, const fs::path& folder) {
  if (node.kind != Yaml::Kind::scalar) scenario::fail(node, "scenarios", "expected a scenario's YAML file");
  return (folder / node.text).lexically_normal();
}

std::vector<fs::path> scenario_files(const Yaml& list, const fs::path& folder) {
  if (list.kind != Yaml::Kind::list || list.items.empty())
    scenario::fail(list, "scenarios", "expected a list of scenarios' YAML files");
  std::vector<fs::path> files;
  for (const Yaml& item : list.items) files.push_back(scenario_file(item, folder));
  return files;
}

void read_grid(const Yaml& map, std::vector<Axis>& axes) {
  require_entries(map, "grid", "keys with values, as in slam.vision.sigma_px: [1, 1.5, 2]");
  for (std::size_t k = 0; k < map.keys.size(); ++k) add_axis(axes, grid_axis(map.keys[k], map.items[k]));
}

MapReaders spec_readers(SweepSpec& spec, const fs::path& folder) {
  return {
      {"scenario", [&spec, folder](const Yaml& value) { spec.scenarios = {scenario_file(value, folder)}; }},
      {"scenarios", [&spec, folder](const Yaml& value) { spec.scenarios = scenario_files(value, folder); }},
      {"seeds", [&spec](const Yaml& value) { spec.seeds = read_seeds(value); }},
      {"grid", [&spec](const Yaml& value) { read_grid(value, spec.axes); }},
      {"zip", [&spec](const Yaml& value) { read_zip(value, spec.axes); }},
      {"sample", [&spec](const Yaml& value) { add_axis(spec.axes, read_sample(value)); }}};
}

bool has_any_key(const Yaml& root, const MapReaders& readers) {
  return std::any_of(root.keys.begin(), root.keys.end(), [&](const Yaml& key) {
    return std::any_of(readers.begin(), readers.end(), [&](const auto& r) { return r.first == key.text; });
  });
}

/// One argument of the command line: its text, and its number from 1.
struct Argument {
  std::string_view text;
  int n = 0;
};

Yaml node_of(const Argument& argument, std::size_t begin, std::string_view text) {
  Yaml node;
  node.kind = Yaml::Kind::scalar;
  node.text = std::string(text);
  node.origin = {kArgument, argument.n, static_cast<int>(begin) + 1};
  return node;
}

/// a,range(1, 2, 3),[4, 5] as a list of nodes. A function is not read as YAML, whose commas would split it.
Yaml list_of(const Argument& argument, const std::vector<Piece>& pieces) {
  Yaml list;
  list.kind = Yaml::Kind::list;
  list.origin = {kArgument, argument.n, static_cast<int>(pieces[0].begin) + 1};
  for (const Piece& piece : pieces) {
    const bool function = piece.text.find('(') != piece.text.npos;
    list.items.push_back(function ? node_of(argument, piece.begin, piece.text)
                                  : scenario::parse_yaml(piece.text, {kArgument, argument.n,
                                                                      static_cast<int>(piece.begin) + 1}));
    if (list.items.back().kind == Yaml::Kind::empty)
      scenario::fail(node_of(argument, piece.begin, ""), "", "a value is missing");
  }
  return list;
}

/// The keys of `KEY=a,b,KEY=c,d` and the list of values of each.
struct Assignments {
  std::vector<Yaml> keys, lists;
};

/// The length of the key that an assignment begins with; 0 if there is none.
std::size_t key_length(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == text.npos) return 0;
  const auto in_key = [](char c) {
    return std::islower(static_cast<unsigned char>(c)) || std::isdigit(static_cast<unsigned char>(c)) ||
           c == '_' || c == '.';
  };
  return std::all_of(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(equals), in_key) ? equals : 0;
}

/// begin: the position of the text in its argument.
Assignments assignments(const Argument& argument, std::size_t begin, std::string_view text) {
  Assignments all;
  std::vector<std::vector<Piece>> values;
  for (Piece piece : split_at_commas(text)) {
    const std::size_t blank = std::min(piece.text.find_first_not_of(' '), piece.text.size());
    piece = {piece.text.substr(blank), piece.begin + begin + blank};
    if (const std::size_t length = key_length(piece.text); length > 0) {
      all.keys.push_back(node_of(argument, piece.begin, piece.text.substr(0, length)));
      values.push_back({{piece.text.substr(length + 1), piece.begin + length + 1}});
    } else if (values.empty()) {
      scenario::fail(node_of(argument, piece.begin, ""), "",
                     fmt::format("'{}': expected KEY=VALUE,VALUE or zip(KEY=..., KEY=...)", piece.text));
    } else {
      values.back().push_back(piece);
    }
  }
  for (const auto& pieces : values) all.lists.push_back(list_of(argument, pieces));
  return all;
}

void read_argument(const Argument& argument, SweepSpec& spec, std::vector<Distribution>& distributions) {
  constexpr std::string_view kZip = "zip(";
  if (argument.text.starts_with(kZip) && argument.text.ends_with(')')) {
    const auto inner = argument.text.substr(kZip.size(), argument.text.size() - kZip.size() - 1);
    const Assignments pairs = assignments(argument, kZip.size(), inner);
    add_axis(spec.axes, zip_axis(pairs.keys, pairs.lists));
    return;
  }
  const Assignments one = assignments(argument, 0, argument.text);
  for (std::size_t k = 0; k < one.keys.size(); ++k) {
    const Yaml& list = one.lists[k];
    if (list.items.size() == 1 && is_distribution(list.items[0]))
      distributions.push_back(distribution(one.keys[k], list.items[0]));
    else
      add_axis(spec.axes, grid_axis(one.keys[k], list));
  }
}

void require_each_key_once(const SweepSpec& spec) {
  std::vector<std::string> seen;
  for (const Axis& axis : spec.axes)
    for (const Setting& setting : axis.front()) {
      if (std::find(seen.begin(), seen.end(), setting.key) != seen.end())
        scenario::fail(setting.at, setting.key, "is given values twice");
      seen.push_back(setting.key);
    }
}

}  // namespace

SweepSpec read_sweep(const fs::path& file, const std::vector<std::string>& arguments,
                     const Sampling& sampling) {
  const Yaml root = parse_yaml_file(file);
  SweepSpec spec{file.stem().string(), {}, {}, {}};
  const MapReaders readers = spec_readers(spec, file.parent_path());
  if (has_any_key(root, readers))
    read_map(root, readers);
  else
    spec.scenarios = {file};
  if (spec.scenarios.empty()) scenario::fail(root, "scenario", "missing, expected a scenario's YAML file");
  std::vector<Distribution> distributions;
  for (std::size_t i = 0; i < arguments.size(); ++i)
    read_argument({arguments[i], static_cast<int>(i) + 1}, spec, distributions);
  if (!distributions.empty()) add_axis(spec.axes, sample_axis(distributions, sampling));
  require_each_key_once(spec);
  return spec;
}

}  // namespace sim::tune
