#include "sim/tune/sweep_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>

#include "sim/bench/scenario_keys.h"
#include "sim/tune/samples.h"
#include "sim/tune/value_list.h"

namespace sim::tune {
namespace {

using bench::Yaml;
using std::string_view_literals::operator""sv;
namespace fs = std::filesystem;

constexpr std::array kSpecKeys{"scenario"sv, "scenarios"sv, "seeds"sv, "grid"sv, "zip"sv, "sample"sv};
constexpr std::array kSampleKeys{"method"sv, "points"sv, "seed"sv, "keys"sv};
constexpr std::array kMethods{"sobol"sv, "random"sv};
constexpr const char* kArgument = "<argument>";

/// Keys of scenarios that a sweep can set.
void require_key(const Yaml& at, const std::string& key) {
  if (key == "seed") bench::fail(at, key, "is not set so, expected seeds (--seeds 1..5)");
  if (key == "name" || key.starts_with("limits."))
    bench::fail(at, key, "does not shape a run, expected a key that does");
  if (bench::find_key(key)) return;
  std::vector<std::string_view> names;
  for (const auto& known : bench::scenario_keys()) names.push_back(known.name);
  bench::fail(at, key, "unknown key" + bench::did_you_mean(key, names));
}

void require_map(const Yaml& node, std::string_view key, std::string_view example) {
  if (node.kind != Yaml::Kind::map || node.keys.empty())
    bench::fail(node, key, fmt::format("expected {}", example));
}

Axis grid_axis(const Yaml& key, const Yaml& values) {
  require_key(key, key.text);
  Axis axis;
  for (Yaml& value : values_of_list(values)) axis.push_back({{key.text, key, std::move(value)}});
  if (axis.empty()) bench::fail(values, key.text, "has no values");
  return axis;
}

/// keys and values: side by side, the i-th values of all keys together.
Axis zip_axis(const std::vector<Yaml>& keys, const std::vector<Yaml>& values) {
  Axis axis = grid_axis(keys[0], values[0]);
  for (std::size_t k = 1; k < keys.size(); ++k) {
    const Axis other = grid_axis(keys[k], values[k]);
    if (other.size() != axis.size())
      bench::fail(values[k], keys[k].text,
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
    bench::fail(value, key.text, "expected uniform(lowest, highest) or loguniform(lowest, highest)");
  const Call call = *call_of(value);
  Distribution d{key, call.name == "loguniform", 0, 0};
  if (call.arguments.size() != 2)
    bench::fail(value, key.text,
                fmt::format("{}(...): has {} numbers, expected 2", call.name, call.arguments.size()));
  d.lowest = call.arguments[0], d.highest = call.arguments[1];
  if (!(d.lowest < d.highest))
    bench::fail(value, key.text, fmt::format("{} is not below {}", d.lowest, d.highest));
  if (d.logarithmic && d.lowest <= 0) bench::fail(value, key.text, "loguniform needs bounds above 0");
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
    bench::fail(
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
  require_map(node, "sample",
              "{method: sobol, points: 32, keys: {slam.vision.sigma_px: loguniform(0.5, 5)}}");
  Sampling sampling;
  std::vector<Distribution> distributions;
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    const std::string& key = node.keys[i].text;
    const Yaml& value = node.items[i];
    if (key == "method") {
      sampling.method = kMethods[bench::read_choice(value, "sample.method", {0, 0, kMethods})];
    } else if (key == "points") {
      bench::read(value, "sample.points", {1, 1e6}, sampling.points);
    } else if (key == "seed") {
      bench::read(value, "sample.seed", {}, sampling.seed);
    } else if (key == "keys") {
      require_map(value, "sample.keys", "keys with uniform(a, b) or loguniform(a, b)");
      for (std::size_t k = 0; k < value.keys.size(); ++k)
        distributions.push_back(distribution(value.keys[k], value.items[k]));
    } else {
      bench::fail(node.keys[i], key, "unknown key" + bench::did_you_mean(key, kSampleKeys));
    }
  }
  if (distributions.empty())
    bench::fail(node, "sample.keys", "missing, expected keys with uniform(a, b) or loguniform(a, b)");
  return sample_axis(distributions, sampling);
}

void read_zip(const Yaml& node, std::vector<Axis>& axes) {
  if (node.kind == Yaml::Kind::list) {
    for (const Yaml& item : node.items) read_zip(item, axes);
    return;
  }
  require_map(node, "zip", "keys with lists of values that go together, or a list of such");
  axes.push_back(zip_axis(node.keys, node.items));
}

fs::path scenario_file(const Yaml& node, const fs::path& folder) {
  if (node.kind != Yaml::Kind::scalar) bench::fail(node, "scenarios", "expected a scenario's YAML file");
  return (folder / node.text).lexically_normal();
}

SweepSpec read_spec(const Yaml& root, const fs::path& file) {
  SweepSpec spec{file.stem().string(), {}, {}, {}};
  const fs::path folder = file.parent_path();
  for (std::size_t i = 0; i < root.keys.size(); ++i) {
    const std::string& key = root.keys[i].text;
    const Yaml& value = root.items[i];
    if (key == "scenario") {
      spec.scenarios.push_back(scenario_file(value, folder));
    } else if (key == "scenarios") {
      if (value.kind != Yaml::Kind::list || value.items.empty())
        bench::fail(value, key, "expected a list of scenarios' YAML files");
      for (const Yaml& item : value.items) spec.scenarios.push_back(scenario_file(item, folder));
    } else if (key == "seeds") {
      if (value.kind != Yaml::Kind::scalar) bench::fail(value, key, "expected seeds, as in 1..5");
      spec.seeds = value;
    } else if (key == "grid") {
      require_map(value, key, "keys with values, as in slam.vision.sigma_px: [1, 1.5, 2]");
      for (std::size_t k = 0; k < value.keys.size(); ++k)
        spec.axes.push_back(grid_axis(value.keys[k], value.items[k]));
    } else if (key == "zip") {
      read_zip(value, spec.axes);
    } else if (key == "sample") {
      spec.axes.push_back(read_sample(value));
    } else {
      bench::fail(root.keys[i], key, "unknown key" + bench::did_you_mean(key, kSpecKeys));
    }
  }
  return spec;
}

/// One argument of the command line: where it begins (the n-th, from 1), and its text.
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

/// a,range(1, 2, 3),[4, 5]: a list of nodes. A function is no YAML list item, its commas would part it.
Yaml list_of(const Argument& argument, const std::vector<Piece>& pieces) {
  Yaml list;
  list.kind = Yaml::Kind::list;
  list.origin = {kArgument, argument.n, static_cast<int>(pieces[0].begin) + 1};
  for (const Piece& piece : pieces) {
    const bool function = piece.text.find('(') != piece.text.npos;
    list.items.push_back(
        function ? node_of(argument, piece.begin, piece.text)
                 : bench::parse_yaml(piece.text, {kArgument, argument.n, static_cast<int>(piece.begin) + 1}));
    if (list.items.back().kind == Yaml::Kind::empty)
      bench::fail(node_of(argument, piece.begin, ""), "", "a value is missing");
  }
  return list;
}

/// The keys of `KEY=a,b,KEY=c,d` and the list of each; `begin`: where the text stands in its argument.
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
      bench::fail(node_of(argument, piece.begin, ""), "",
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
    spec.axes.push_back(zip_axis(pairs.keys, pairs.lists));
    return;
  }
  const Assignments one = assignments(argument, 0, argument.text);
  for (std::size_t k = 0; k < one.keys.size(); ++k) {
    const Yaml& list = one.lists[k];
    if (list.items.size() == 1 && is_distribution(list.items[0]))
      distributions.push_back(distribution(one.keys[k], list.items[0]));
    else
      spec.axes.push_back(grid_axis(one.keys[k], list));
  }
}

void require_each_key_once(const SweepSpec& spec) {
  std::vector<std::string> seen;
  for (const Axis& axis : spec.axes)
    for (const Setting& setting : axis.front()) {
      if (std::find(seen.begin(), seen.end(), setting.key) != seen.end())
        bench::fail(setting.at, setting.key, "is given values twice");
      seen.push_back(setting.key);
    }
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || fs::is_directory(file))
    throw bench::ConfigError(
        fmt::format("{}: cannot be read: {}", file.string(), std::strerror(in ? EISDIR : errno)));
  return {std::istreambuf_iterator<char>(in), {}};
}

bool is_spec(const Yaml& root) {
  return root.kind == Yaml::Kind::map && std::any_of(root.keys.begin(), root.keys.end(), [](const Yaml& key) {
           return std::find(kSpecKeys.begin(), kSpecKeys.end(), key.text) != kSpecKeys.end();
         });
}

}  // namespace

SweepSpec read_sweep(const fs::path& file, const std::vector<std::string>& arguments,
                     const Sampling& sampling) {
  const Yaml root = bench::parse_yaml(text_of(file), {file.string()});
  SweepSpec spec = is_spec(root) ? read_spec(root, file) : SweepSpec{file.stem().string(), {file}, {}, {}};
  if (spec.scenarios.empty()) bench::fail(root, "scenario", "missing, expected a scenario's YAML file");
  std::vector<Distribution> distributions;
  for (std::size_t i = 0; i < arguments.size(); ++i)
    read_argument({arguments[i], static_cast<int>(i) + 1}, spec, distributions);
  if (!distributions.empty()) spec.axes.push_back(sample_axis(distributions, sampling));
  require_each_key_once(spec);
  return spec;
}

}  // namespace sim::tune
