// Points spread over a unit cube: random, or of the Sobol sequence, which fills it more evenly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sim::tune {

/// The largest dimension for which Boost has direction numbers.
inline constexpr std::size_t kMostSobolDimensions = 3667;

/// The first n points of the Sobol sequence after the origin (Boost's direction numbers, those of Joe and Kuo
/// 2008), of 32 bits each. A seed other than 0 adds a random digital shift to each dimension. Of 2^k - 1
/// points and the origin, each dimension has one in each of 2^k equal parts.
std::vector<std::vector<double>> sobol_points(std::size_t n, std::size_t dimensions, std::uint64_t seed);

/// n points whose coordinates are independent and uniform on [0, 1).
std::vector<std::vector<double>> random_points(std::size_t n, std::size_t dimensions, std::uint64_t seed);

}  // namespace sim::tune
