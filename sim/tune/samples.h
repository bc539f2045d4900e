// Points spread over a unit cube: random, or of the Sobol sequence, which fills it more evenly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sim::tune {

/// Up to so many dimensions have direction numbers here.
inline constexpr std::size_t kMostSobolDimensions = 10;

/// The first points of the Sobol sequence after the origin (Joe & Kuo 2008, direction numbers new-joe-kuo-6),
/// of 32 bits each, every dimension shifted digit by digit by the seed's own number; seed 0: not shifted. Of
/// 2^k - 1 points and the origin, each dimension has one in each of 2^k equal parts.
std::vector<std::vector<double>> sobol_points(std::size_t n, std::size_t dimensions, std::uint64_t seed);

/// Independent and uniform.
std::vector<std::vector<double>> random_points(std::size_t n, std::size_t dimensions, std::uint64_t seed);

}  // namespace sim::tune
