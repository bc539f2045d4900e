#include "sim/trials/values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/random/sobol.hpp>
#include <cmath>

#include "sim/scenario/keys.h"
#include "sim/scenario/value.h"
#include "sim/scenario/yaml.h"

namespace sim::trials {
namespace {

using scenario::fail;
using scenario::Yaml;
using std::string_view_literals::operator""sv;

constexpr std::array kScales{"log"sv, "linear"sv};
constexpr scenario::Domain kAnyNumber{-1e12, 1e12};
constexpr double kMostPoints = 100'000;

bool is_number(const scenario::Key& key) {
  return key.expected.starts_with("a number") || key.expected.starts_with("a whole number");
}

void require_number(const Yaml& at, const std::string& name) {
  const auto* const key = scenario::find_key(name);
  if (key && is_number(*key)) return;
  if (key) fail(at, name, fmt::format("is {}, expected a key that is a number", key->expected));
  fail(at, name, scenario::unknown_key(name));
}

// A number that the key itself accepts.
double read_bound(const Yaml& node, const std::string& key) {
  scenario::Scenario scratch = scenario::default_scenario();
  scenario::find_key(key)->read(node, scratch);
  double value = 0;
  read(node, key, kAnyNumber, value);
  return value;
}

void require_rising(const Yaml& node, const Range& range) {
  if (std::isnan(range.low) || std::isnan(range.high)) fail(node, range.key, "expected both from and to");
  if (!(range.low < range.high))
    fail(node, range.key, fmt::format("from {} to {}: expected a rising range", range.low, range.high));
  if (range.logarithmic && range.low <= 0)
    fail(node, range.key, "a logarithmic range must start above 0; scale: linear allows 0 and below");
  if (range.start < range.low || range.start > range.high)
    fail(node, range.key, fmt::format("start {} is outside {} to {}", range.start, range.low, range.high));
}

bool is_range(const Yaml& node) {
  return node.kind == Yaml::Kind::map && std::any_of(node.keys.begin(), node.keys.end(), [](const Yaml& key) {
           return key.text == "from" || key.text == "to";
         });
}

}  // namespace

double Range::value_at(double coordinate) const {
  if (coordinate <= 0) return low;
  if (coordinate >= 1) return high;
  return logarithmic ? low * std::exp(coordinate * std::log(high / low)) : low + coordinate * (high - low);
}

double Range::coordinate_of(double value) const {
  const double coordinate =
      logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
  return std::clamp(coordinate, 0.0, 1.0);
}

std::vector<double> Range::grid() const {
  std::vector<double> values;
  for (int i = 0; i < points; ++i) values.push_back(value_at(i / std::max(points - 1.0, 1.0)));
  return values;
}

Range read_range(const Yaml& key, const Yaml& node) {
  require_number(key, key.text);
  require_map(node, key.text, "a range, as in {from: 0.001, to: 0.1}");
  Range range{key.text, {}, NAN, NAN, NAN, true, 0};
  const auto bound = [&](double& into) {
    return [&](const Yaml& value) { into = read_bound(value, range.key); };
  };
  read_map(node, {{"from", bound(range.low)},
                  {"to", bound(range.high)},
                  {"start", bound(range.start)},
                  {"scale",
                   [&](const Yaml& value) {
                     range.logarithmic = read_choice(value, "scale", {0, 0, kScales}) == 0;
                   }},
                  {"points",
                   [&](const Yaml& value) {
                     scenario::read(value, "points", {2, kMostPoints}, range.points);
                   }},
                  {"also", [&](const Yaml& value) {
                     range.also = read_texts(value, "also", "[slam.vision.gate_sigma_px]");
                     for (const Yaml& item : value.items) require_number(item, item.text);
                   }}});
  require_rising(node, range);
  return range;
}

Values read_values(const Yaml& key, const Yaml& node) {
  if (node.kind == Yaml::Kind::list && node.items.size() == 1 && is_range(node.items[0]))
    return read_range(key, node.items[0]);
  if (is_range(node)) return read_range(key, node);
  if (node.kind != Yaml::Kind::list) return std::vector{node};
  if (node.items.empty()) fail(node, key.text, "has no values");
  for (const Yaml& item : node.items)
    if (item.kind == Yaml::Kind::empty) fail(item, key.text, "a value is missing");
  return node.items;
}

Yaml number_node(double value, const scenario::Origin& origin, bool shortest) {
  Yaml node;
  node.kind = Yaml::Kind::scalar;
  node.text = shortest ? fmt::format("{:.12g}", value) : fmt::format("{}", value);
  node.origin = origin;
  return node;
}

void set(scenario::Scenario& scenario, const std::string& key, double value) {
  scenario::find_key(key)->read(number_node(value, {key}, false), scenario);
}

std::vector<std::vector<double>> sobol_points(std::size_t n, std::size_t dimensions) {
  boost::random::sobol sequence(dimensions);
  std::vector<std::vector<double>> points(n, std::vector<double>(dimensions));
  for (std::vector<double>& point : points)
    for (double& coordinate : point) coordinate = 0x1p-64 * static_cast<double>(sequence());
  return points;
}

}  // namespace sim::trials
