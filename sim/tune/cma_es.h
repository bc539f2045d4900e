// CMA-ES: a search that learns which way the settings are stretched (Hansen 2016, "The CMA Evolution
// Strategy: A Tutorial").
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/stream/random.h"

namespace sim::tune {

/// Looks for the least value in the unit cube. Asked for a generation, told its values, asked again.
/// pagmo's own would mix two layouts of Eigen's memory: Debian builds it without AVX.
class CmaEs {
 public:
  /// start: of the mean; step: standard deviation of the first generation; count >= 4: of a generation.
  CmaEs(const std::vector<double>& start, double step, int count, std::uint64_t seed);

  /// A generation; what falls outside the cube is mirrored at its faces.
  std::vector<std::vector<double>> ask();
  /// Values of the generation that was asked for last.
  void tell(const std::vector<double>& values);

 private:
  Eigen::VectorXd sample();
  void adapt(const Eigen::VectorXd& step);

  int n_, count_, generation_ = 0;
  Eigen::VectorXd weights_;  // of the better half
  double mu_eff_, c_sigma_, d_sigma_, c_c_, c_1_, c_mu_, expected_length_;
  double sigma_;
  Eigen::VectorXd mean_, p_sigma_, p_c_, D_;  // C = B D² Bᵀ
  Eigen::MatrixXd C_, B_, asked_;             // a column for each that was asked for
  stream::Random random_;
};

}  // namespace sim::tune
