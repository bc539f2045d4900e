// The cart-table model, and preview control, which finds the jerk that makes its ZMP follow a reference known
// in advance. The second stage shifts the planned center of mass so that the ZMP of the whole body follows,
// too.
#pragma once

#include <deque>

#include "walking/kinematics.h"

namespace walking {

/// One axis, state (position, velocity, acceleration), input jerk: x(k+1) = A x(k) + B u(k), ZMP p = C x
/// (Kajita et al. 2003; Stasse et al. 2006, eqs. (1) and (2)).
struct CartTable {
  /// `period` in s, `com_height` in m, `gravity` in m/s²; all positive.
  explicit CartTable(double com_height, double period = kPeriod, double gravity = kGravity);

  Eigen::Matrix3d A;
  Eigen::Vector3d B;
  Eigen::RowVector3d C;
};

/// Gains of u(k) = -integral sum e(i) - state x(k) - sum_j preview(j) p_ref(k + j).
struct PreviewGains {
  double integral = 0;       ///< G_i
  Eigen::RowVector3d state;  ///< G_x
  Eigen::VectorXd preview;   ///< G_p(1) ... G_p(horizon), element 0 is j = 1
};

/// Optimal gains for a horizon in ticks (at least 1), found by plain iteration of the Riccati equation of the
/// error-and-increments system (Katayama et al. 1985; Kajita et al. 2003). The cost weighs the squared ZMP
/// error with 1 and the squared change of the jerk with 1e-6.
PreviewGains preview_gains(const CartTable& cart, int horizon);

/// The reference of this tick and of the next `horizon` ticks.
class PreviewWindow {
 public:
  explicit PreviewWindow(int horizon) : values_(horizon + 1, 2) {}

  void push(const Eigen::Vector2d& latest);  ///< must not be full
  void pop();                                ///< drops the earliest value
  bool full() const { return filled_ == values_.rows(); }
  Eigen::Vector2d now() const { return values_.row(0); }
  auto ahead() const { return values_.bottomRows(values_.rows() - 1); }  ///< row j: j + 1 ticks ahead

 private:
  Eigen::MatrixX2d values_;
  Eigen::Index filled_ = 0;
};

/// The control loop, both horizontal axes side by side (column 0: x, column 1: y).
class PreviewControl {
 public:
  using State = Eigen::Matrix<double, 3, 2>;  ///< rows: position, velocity, acceleration

  /// Starts at rest at `position`, as if it had stood there for a long time.
  PreviewControl(const CartTable& cart, PreviewGains gains, const Eigen::Vector2d& position);

  const State& state() const { return x_; }
  Eigen::Vector2d zmp() const { return (cart_.C * x_).transpose(); }

  /// Advances one tick. The window must be full, be as long as the gains' preview, and start with this tick's
  /// reference.
  void advance(const PreviewWindow& reference);

 private:
  CartTable cart_;
  PreviewGains gains_;
  State x_ = State::Zero();
  Eigen::RowVector2d error_sum_ = Eigen::RowVector2d::Zero();
};

/// The "dynamic filter" of Kajita et al. 2003: the cart-table's plan is played through a model of all links.
/// The ZMP error found there, one preview ahead, is the reference of a second preview control, which corrects
/// it.
class SecondPreview {
 public:
  SecondPreview(const Robot& robot, WholeBody model, const CartTable& cart, const PreviewGains& gains);

  /// Adds the first stage's plan, tick by tick.
  void push(const Reference& planned);

  /// Returns whether enough ticks have been pushed to correct the next one: preview + 2.
  bool ready() const { return errors_.full(); }

  /// Returns the next tick's reference, corrected.
  Reference pop();

 private:
  Robot robot_;
  WholeBody model_;
  int horizon_;
  PreviewWindow errors_;
  PreviewControl control_;
  std::deque<Reference> planned_;  // pushed but not popped
  BodyPose pose_;                  // pose at the last reference pushed
  BodyMomentum momentum_;          // half a tick before it
  int errors_pushed_ = 0;
};

}  // namespace walking
