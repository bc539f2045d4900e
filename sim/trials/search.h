// The search for the best setting: CMA-ES over the whole range.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/sensor_errors/random.h"

namespace sim::trials {

/// CMA-ES, covariance matrix adaptation evolution strategy (Hansen 2016, "The CMA Evolution Strategy: A
/// Tutorial"): minimizes a function on the unit cube by ask() and tell(). Written
/// here because Debian's pagmo is built without AVX, so that its Eigen matrices are aligned differently.
class CmaEs {
 public:
  /// start: mean of the first generation; step: its standard deviation; count >= 4: size of a generation.
  CmaEs(const std::vector<double>& start, double step, int count, std::uint64_t seed);

  /// The next generation. Points outside the cube are reflected at its faces.
  std::vector<std::vector<double>> ask();
  /// The values of the last generation, in its order.
  void tell(const std::vector<double>& values);

 private:
  Eigen::VectorXd sample();
  void adapt(const Eigen::VectorXd& step);

  int n_, count_, generation_ = 0;
  Eigen::VectorXd weights_;  // of the better half
  double mu_eff_, c_sigma_, d_sigma_, c_c_, c_1_, c_mu_, expected_length_;
  double sigma_;
  Eigen::VectorXd mean_, p_sigma_, p_c_, D_;  // C = B D² Bᵀ
  Eigen::MatrixXd C_, B_, asked_;             // asked_: a column for each point
  sensor_errors::Random random_;
};

}  // namespace sim::trials
