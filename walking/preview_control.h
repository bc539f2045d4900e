// Preview control: the jerk that makes the cart-table's ZMP follow a reference known some time ahead.
#pragma once

#include <Eigen/Core>

#include "walking/cart_table.h"

namespace walking {

/// Weights of the cost: squared ZMP error, squared change of the state, squared change of the jerk.
struct PreviewWeights {
  double error = 1, state = 0, input = 1e-6;
};

/// Gains of u(k) = -integral sum e(i) - state x(k) - sum_j preview(j) p_ref(k + j).
struct PreviewGains {
  double integral = 0;       ///< G_i
  Eigen::RowVector3d state;  ///< G_x
  Eigen::VectorXd preview;   ///< G_p(1) ... G_p(horizon), element 0 is j = 1
};

/// Optimal gains for a horizon of so many ticks (at least 1), by plain iteration of the Riccati equation of
/// the error-and-increments system (Katayama et al. 1985; Kajita et al. 2003).
PreviewGains preview_gains(const CartTable& cart, int horizon, const PreviewWeights& weights = {});

/// The control loop, both horizontal axes side by side (column 0: x, column 1: y).
class PreviewControl {
 public:
  using State = Eigen::Matrix<double, 3, 2>;  ///< rows: position, velocity, acceleration

  /// Starts at rest at `position`, having stood there for long.
  PreviewControl(const CartTable& cart, PreviewGains gains, const Eigen::Vector2d& position);

  const State& state() const { return x_; }
  Eigen::Vector2d zmp() const { return (cart_.C * x_).transpose(); }

  /// One tick: `now` is the reference of this tick, row j of `ahead` that of j + 1 ticks later.
  void advance(const Eigen::Vector2d& now, const Eigen::Ref<const Eigen::MatrixX2d>& ahead);

 private:
  CartTable cart_;
  PreviewGains gains_;
  State x_ = State::Zero();
  Eigen::RowVector2d error_sum_ = Eigen::RowVector2d::Zero();
};

}  // namespace walking
