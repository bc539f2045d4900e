#include "sim/trials/values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>

#include "sim/scenario/keys.h"
#include "sim/scenario/value.h"
#include "sim/scenario/yaml_map.h"

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

// Direction numbers m_1, m_2, ... of one dimension, with the degree s and the coefficients a of its primitive
// polynomial: the head of new-joe-kuo-6.21201 (Joe and Kuo 2008).
struct SobolDimension {
  unsigned s, a;
  std::array<std::uint32_t, 5> m;
};
constexpr std::array<SobolDimension, kMostSobolDimensions - 1> kJoeKuo{{{1, 0, {1}},
                                                                        {2, 1, {1, 3}},
                                                                        {3, 1, {1, 3, 1}},
                                                                        {3, 2, {1, 1, 1}},
                                                                        {4, 1, {1, 1, 3, 3}},
                                                                        {4, 4, {1, 3, 5, 13}},
                                                                        {5, 2, {1, 1, 5, 5, 17}},
                                                                        {5, 4, {1, 1, 5, 5, 5}},
                                                                        {5, 7, {1, 1, 7, 11, 19}},
                                                                        {5, 11, {1, 1, 5, 1, 1}}}};

// The direction numbers as binary fractions of 32 bits.
std::array<std::uint32_t, 32> directions(std::size_t dimension) {
  std::array<std::uint32_t, 32> v{};
  if (dimension == 0) {
    for (unsigned i = 0; i < 32; ++i) v[i] = 1u << (31 - i);
    return v;
  }
  const auto& [s, a, m] = kJoeKuo[dimension - 1];
  for (unsigned i = 0; i < s; ++i) v[i] = m[i] << (31 - i);
  for (unsigned i = s; i < 32; ++i) {
    v[i] = v[i - s] ^ (v[i - s] >> s);
    for (unsigned k = 1; k < s; ++k)
      if ((a >> (s - 1 - k)) & 1u) v[i] ^= v[i - k];
  }
  return v;
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

// In Gray code order (Antonov and Saleev 1979), as published with the direction numbers.
std::vector<std::vector<double>> sobol_points(std::size_t n, std::size_t dimensions) {
  assert(dimensions <= kMostSobolDimensions && n < (std::size_t{1} << 31));
  std::vector<std::vector<double>> points(n, std::vector<double>(dimensions));
  for (std::size_t d = 0; d < dimensions; ++d) {
    const auto v = directions(d);
    std::uint32_t x = 0;
    for (std::size_t i = 0; i < n; ++i) {
      x ^= v[static_cast<std::size_t>(std::countr_one(i))];
      points[i][d] = x / 4294967296.0;
    }
  }
  return points;
}

}  // namespace sim::trials
