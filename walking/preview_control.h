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

/// The reference of this tick and of the `horizon` ticks that follow, kept up as time goes on.
class PreviewWindow {
 public:
  explicit PreviewWindow(int horizon) : values_(horizon + 1, 2) {}

  void push(const Eigen::Vector2d& latest);  ///< not full before
  void pop();                                ///< drops the earliest
  bool full() const { return filled_ == values_.rows(); }
  Eigen::Vector2d now() const { return values_.row(0); }
  auto ahead() const { return values_.bottomRows(values_.rows() - 1); }  ///< row j: in j + 1 ticks

 private:
  Eigen::MatrixX2d values_;
  Eigen::Index filled_ = 0;
};

/// The control loop, both horizontal axes side by side (column 0: x, column 1: y).
class PreviewControl {
 public:
  using State = Eigen::Matrix<double, 3, 2>;  ///< rows: position, velocity, acceleration

  /// Starts at rest at `position`, having stood there for long.
  PreviewControl(const CartTable& cart, PreviewGains gains, const Eigen::Vector2d& position);

  const State& state() const { return x_; }
  Eigen::Vector2d zmp() const { return (cart_.C * x_).transpose(); }

  /// One tick. The window is full, as long as the gains' preview, and begins with this tick's reference.
  void advance(const PreviewWindow& reference);

 private:
  CartTable cart_;
  PreviewGains gains_;
  State x_ = State::Zero();
  Eigen::RowVector2d error_sum_ = Eigen::RowVector2d::Zero();
};

}  // namespace walking
