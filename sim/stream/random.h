// Named random streams from one seed: a counter-based generator, so that a new consumer never shifts
// another's numbers.
#pragma once

#include <cstdint>
#include <string_view>

namespace sim::stream {

/// Numbers of one named stream of one seed. Same seed and name: same numbers, on every machine: integer
/// arithmetic and IEEE operations alone, no function of the C library whose last bit may differ.
class Random {
 public:
  Random(std::uint64_t seed, std::string_view stream);
  /// The sub-stream of one item (a frame, a sample; its stamp will do): drawn alike in whatever order items
  /// come.
  Random(std::uint64_t seed, std::string_view stream, std::uint64_t item);
  std::uint64_t bits();  ///< 64 uniform bits
  double uniform();      ///< [0, 1)
  double normal();       ///< mean 0, standard deviation 1
 private:
  std::uint64_t key_ = 0, counter_ = 0;
};

/// The standard normal distribution's quantile of p in (0, 1), to about 1e-15 relative (Wichura 1988,
/// algorithm AS 241).
double normal_quantile(double p);

}  // namespace sim::stream
