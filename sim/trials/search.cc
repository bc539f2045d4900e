#include "sim/trials/search.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace sim::trials {
namespace {

// Reflects into [0, 1] at both ends.
double reflected(double x) { return std::min(std::abs(std::remainder(x, 2)), 1.0); }

}  // namespace

// Equations and default values of table 1 of the tutorial, without negative weights.
CmaEs::CmaEs(const std::vector<double>& start, double step, int count, std::uint64_t seed)
    : n_(static_cast<int>(start.size())), count_(count), sigma_(step), random_(seed, "cma-es") {
  const int better = count / 2;
  weights_ = Eigen::VectorXd::NullaryExpr(better, [&](Eigen::Index i) {
    return std::log((count + 1) / 2.0) - std::log(1.0 + static_cast<double>(i));
  });
  weights_ /= weights_.sum();
  const double n = n_;
  mu_eff_ = 1 / weights_.squaredNorm();
  c_sigma_ = (mu_eff_ + 2) / (n + mu_eff_ + 5);
  d_sigma_ = 1 + 2 * std::max(0.0, std::sqrt((mu_eff_ - 1) / (n + 1)) - 1) + c_sigma_;
  c_c_ = (4 + mu_eff_ / n) / (n + 4 + 2 * mu_eff_ / n);
  c_1_ = 2 / ((n + 1.3) * (n + 1.3) + mu_eff_);
  c_mu_ = std::min(1 - c_1_, 2 * (0.25 + mu_eff_ + 1 / mu_eff_ - 2) / ((n + 2) * (n + 2) + mu_eff_));
  expected_length_ = std::sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n));
  mean_ = Eigen::Map<const Eigen::VectorXd>(start.data(), n_);
  p_sigma_ = p_c_ = Eigen::VectorXd::Zero(n_);
  D_ = Eigen::VectorXd::Ones(n_);
  C_ = B_ = Eigen::MatrixXd::Identity(n_, n_);
  asked_.resize(n_, count_);
}

Eigen::VectorXd CmaEs::sample() {
  Eigen::VectorXd z(n_);
  for (double& value : z) value = random_.normal();
  const Eigen::VectorXd x = mean_ + sigma_ * (B_ * D_.cwiseProduct(z));
  return x.unaryExpr([](double value) { return reflected(value); });
}

std::vector<std::vector<double>> CmaEs::ask() {
  std::vector<std::vector<double>> all;
  for (int k = 0; k < count_; ++k) {
    asked_.col(k) = sample();
    all.emplace_back(asked_.col(k).begin(), asked_.col(k).end());
  }
  return all;
}

void CmaEs::tell(const std::vector<double>& values) {
  std::vector<Eigen::Index> order(values.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return values[static_cast<std::size_t>(a)] < values[static_cast<std::size_t>(b)];
  });
  order.resize(static_cast<std::size_t>(weights_.size()));
  const Eigen::MatrixXd Y = (asked_(Eigen::all, order).colwise() - mean_) / sigma_;
  const Eigen::VectorXd step = Y * weights_;  // eq. (41)
  mean_ += sigma_ * step;
  adapt(step);
  C_ += c_mu_ * (Y * weights_.asDiagonal() * Y.transpose());  // the rest of eq. (47)
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen((C_ + C_.transpose()) / 2);
  B_ = eigen.eigenvectors();
  D_ = eigen.eigenvalues().cwiseMax(1e-20).cwiseSqrt();
  ++generation_;
}

// Paths, step size, and the terms of eq. (47) other than this generation's.
void CmaEs::adapt(const Eigen::VectorXd& step) {
  const Eigen::VectorXd white = B_ * (B_.transpose() * step).cwiseQuotient(D_);  // C^(−1/2) y
  p_sigma_ = (1 - c_sigma_) * p_sigma_ + std::sqrt(c_sigma_ * (2 - c_sigma_) * mu_eff_) * white;  // eq. (43)
  const double length = p_sigma_.norm();
  const double settled = std::sqrt(1 - std::pow(1 - c_sigma_, 2 * (generation_ + 1)));
  const bool straight = length / settled < (1.4 + 2 / (n_ + 1.0)) * expected_length_;
  p_c_ *= 1 - c_c_;
  if (straight) p_c_ += std::sqrt(c_c_ * (2 - c_c_) * mu_eff_) * step;  // eq. (45)
  const double kept = 1 - c_1_ - c_mu_ + (straight ? 0 : c_1_ * c_c_ * (2 - c_c_));
  C_ = kept * C_ + c_1_ * p_c_ * p_c_.transpose();
  sigma_ *= std::exp(std::min(1.0, c_sigma_ / d_sigma_ * (length / expected_length_ - 1)));  // eq. (44)
}

}  // namespace sim::trials
