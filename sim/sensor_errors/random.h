// Named random streams from one seed. The generator is counter-based: new streams do not change others.
#pragma once

#include <cstdint>
#include <string_view>

namespace sim::sensor_errors {

/// The numbers of one named stream for one seed. They are the same on every machine, because they are
/// computed only with integer arithmetic and IEEE operations, without functions of the C library.
class Random {
 public:
  Random(std::uint64_t seed, std::string_view stream);
  /// The sub-stream for one item, such as a frame's stamp. It does not depend on the order of draws.
  Random(std::uint64_t seed, std::string_view stream, std::uint64_t item);
  std::uint64_t bits();  ///< 64 uniform bits
  double uniform();      ///< [0, 1)
  double normal();       ///< mean 0, standard deviation 1
 private:
  std::uint64_t key_ = 0, counter_ = 0;
};

/// The standard normal quantile of p in (0, 1), to about 1e-15 relative (Wichura 1988, algorithm AS 241).
double normal_quantile(double p);

}  // namespace sim::sensor_errors
