#include "sim/tune/samples.h"

#include <array>
#include <bit>
#include <cassert>

#include "sim/stream/random.h"

namespace sim::tune {
namespace {

constexpr int kBits = 32;
using Directions = std::array<std::uint32_t, kBits>;

/// A primitive polynomial of degree s with inner coefficients a, and the first s odd direction integers.
struct Polynomial {
  int s;
  std::uint32_t a;
  std::array<std::uint32_t, 5> m;
};

/// Joe & Kuo, "Constructing Sobol sequences with better two-dimensional projections" (2008), dimensions 2
/// to 10.
constexpr std::array<Polynomial, kMostSobolDimensions - 1> kPolynomials{{{1, 0, {1}},
                                                                         {2, 1, {1, 3}},
                                                                         {3, 1, {1, 3, 1}},
                                                                         {3, 2, {1, 1, 1}},
                                                                         {4, 1, {1, 1, 3, 3}},
                                                                         {4, 4, {1, 3, 5, 13}},
                                                                         {5, 2, {1, 1, 5, 5, 17}},
                                                                         {5, 4, {1, 1, 5, 5, 5}},
                                                                         {5, 7, {1, 1, 7, 11, 19}}}};

Directions directions(std::size_t dimension) {
  Directions v{};
  if (dimension == 0) {
    for (int i = 0; i < kBits; ++i) v[i] = 1u << (kBits - 1 - i);
    return v;
  }
  const auto& [s, a, m] = kPolynomials[dimension - 1];
  for (int i = 0; i < s; ++i) v[i] = m[i] << (kBits - 1 - i);
  for (int i = s; i < kBits; ++i) {
    v[i] = v[i - s] ^ (v[i - s] >> s);
    for (int k = 1; k < s; ++k) v[i] ^= ((a >> (s - 1 - k)) & 1u) * v[i - k];
  }
  return v;
}

}  // namespace

std::vector<std::vector<double>> sobol_points(std::size_t n, std::size_t dimensions, std::uint64_t seed) {
  assert(dimensions <= kMostSobolDimensions && n < (std::size_t{1} << 31));
  std::vector<std::vector<double>> points(n, std::vector<double>(dimensions));
  for (std::size_t d = 0; d < dimensions; ++d) {
    const Directions v = directions(d);
    const std::uint32_t shift =
        seed == 0 ? 0 : static_cast<std::uint32_t>(stream::Random(seed, "sobol shift", d).bits() >> kBits);
    std::uint32_t x = 0;
    for (std::size_t i = 0; i < n; ++i) {
      x ^= v[static_cast<std::size_t>(std::countr_one(i))];  // in the order of the Gray code
      points[i][d] = static_cast<double>(x ^ shift) / 4294967296.0;
    }
  }
  return points;
}

std::vector<std::vector<double>> random_points(std::size_t n, std::size_t dimensions, std::uint64_t seed) {
  std::vector<std::vector<double>> points(n, std::vector<double>(dimensions));
  for (std::size_t i = 0; i < n; ++i) {
    stream::Random random(seed, "random sample", i);
    for (double& x : points[i]) x = random.uniform();
  }
  return points;
}

}  // namespace sim::tune
