// Central differences of any vector function: what every analytic Jacobian is compared with.
#pragma once

#include <Eigen/Core>

namespace tests {

/// ∂f/∂x at x by central differences with the given step; f maps Eigen::VectorXd to Eigen::VectorXd.
template <typename Function>
Eigen::MatrixXd numerical_jacobian(const Function& f, const Eigen::VectorXd& x, double step = 1e-6) {
  Eigen::MatrixXd J;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    Eigen::VectorXd above = x, below = x;
    above(i) += step;
    below(i) -= step;
    const Eigen::VectorXd slope = (Eigen::VectorXd(f(above)) - Eigen::VectorXd(f(below))) / (2 * step);
    if (i == 0) J.resize(slope.size(), x.size());
    J.col(i) = slope;
  }
  return J;
}

}  // namespace tests
