#include "sim/tune/samples.h"

#include <boost/random/sobol.hpp>
#include <cassert>

#include "sim/sensor_errors/random.h"

namespace sim::tune {

static_assert(kMostSobolDimensions == boost::random::default_sobol_table::max_dimension);

std::vector<std::vector<double>> sobol_points(std::size_t n, std::size_t dimensions, std::uint64_t seed) {
  assert(dimensions <= kMostSobolDimensions && n < (std::size_t{1} << 31));
  std::vector<std::uint32_t> shift(dimensions, 0);
  for (std::size_t d = 0; seed != 0 && d < dimensions; ++d)
    shift[d] = static_cast<std::uint32_t>(sensor_errors::Random(seed, "sobol shift", d).bits() >> 32);
  boost::random::sobol_engine<std::uint32_t, 32> sequence(dimensions);
  std::vector<std::vector<double>> points(n, std::vector<double>(dimensions));
  for (auto& point : points)
    for (std::size_t d = 0; d < dimensions; ++d)
      point[d] = static_cast<double>(sequence() ^ shift[d]) / 4294967296.0;
  return points;
}

std::vector<std::vector<double>> random_points(std::size_t n, std::size_t dimensions, std::uint64_t seed) {
  std::vector<std::vector<double>> points(n, std::vector<double>(dimensions));
  for (std::size_t i = 0; i < n; ++i) {
    sensor_errors::Random random(seed, "random sample", i);
    for (double& x : points[i]) x = random.uniform();
  }
  return points;
}

}  // namespace sim::tune
