// Named random streams from one seed: a counter-based generator, so that a new consumer never shifts another's numbers.
#pragma once

#include <cstdint>
#include <string_view>

namespace sim::stream {

/// Numbers of one named stream of one seed. Same seed and name: same numbers, on every machine.
class Random {
 public:
  Random(std::uint64_t seed, std::string_view stream);
  std::uint64_t bits();    ///< 64 uniform bits
  double uniform();        ///< [0, 1)
  double normal();         ///< mean 0, standard deviation 1
 private:
  std::uint64_t key_ = 0, counter_ = 0;
};

}  // namespace sim::stream
