#include "walking/preview_control.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "walking/timeline.h"

namespace walking {
CartTable::CartTable(double com_height, double period, double gravity) {
  const double T = period;
  A << 1, T, T * T / 2, 0, 1, T, 0, 0, 1;
  B << T * T * T / 6, T * T / 2, T;
  C << 1, 0, -com_height / gravity;
}

namespace {

/// State [e; dx], input du: the cart-table in increments, preceded by its ZMP error e.
struct ErrorSystem {
  explicit ErrorSystem(const CartTable& cart) {
    F << cart.C * cart.A, cart.A;
    A << Eigen::Vector4d::UnitX(), F;
    B << cart.C * cart.B, cart.B;
  }
  Eigen::Matrix<double, 4, 3> F;
  Eigen::Matrix4d A;
  Eigen::Vector4d B;
};

/// The stabilizing solution P of the discrete algebraic Riccati equation.
Eigen::Matrix4d riccati(const ErrorSystem& system, const Eigen::Matrix4d& Q, double R) {
  constexpr int kMost = 1000000;        // a high center of mass and a short period make the slowest pole slow
  constexpr double kConverged = 1e-15;  // relative change; one iteration reduces the error by about 3 %
  Eigen::Matrix4d P = Q;
  for (int i = 0; i < kMost; ++i) {
    const Eigen::RowVector4d BPA = system.B.transpose() * P * system.A;
    const double S = R + system.B.dot(P * system.B);
    const Eigen::Matrix4d next = system.A.transpose() * P * system.A - BPA.transpose() * (BPA / S) + Q;
    const double change = (next - P).norm();
    P = (next + next.transpose()) / 2;
    if (change <= kConverged * P.norm()) break;
  }
  return P;
}

}  // namespace

PreviewGains preview_gains(const CartTable& cart, int horizon) {
  assert(horizon >= 1);
  constexpr double kInput = 1e-6;  // weight of the squared change of the jerk; the ZMP error has weight 1
  const ErrorSystem system(cart);
  const Eigen::Matrix4d Q = Eigen::Vector4d::UnitX().asDiagonal();
  const Eigen::Matrix4d P = riccati(system, Q, kInput);
  const Eigen::RowVector4d BP_S = system.B.transpose() * P / (kInput + system.B.dot(P * system.B));
  PreviewGains gains;
  gains.integral = BP_S(0);
  gains.state = BP_S * system.F;
  gains.preview.resize(horizon);
  gains.preview(0) = -gains.integral;
  const Eigen::Matrix4d closed_loop = system.A - system.B * (BP_S * system.A);
  const Eigen::RowVector4d B_S = system.B.transpose() / (kInput + system.B.dot(P * system.B));
  Eigen::Vector4d X = -closed_loop.transpose() * P.col(0);
  for (int j = 1; j < horizon; ++j) {
    gains.preview(j) = B_S * X;
    X = closed_loop.transpose() * X;
  }
  return gains;
}

PreviewControl::PreviewControl(const CartTable& cart, PreviewGains gains, const Eigen::Vector2d& position)
    : cart_(cart), gains_(std::move(gains)) {
  x_.row(0) = position;
  // The gains of a finite preview add up to less than the position gain. The error sum starts as if the
  // robot had stood here for a long time, so that the walk is the same for any starting place.
  error_sum_ = -(gains_.state(0) + gains_.preview.sum()) / gains_.integral * position;
}

void PreviewControl::advance(const PreviewWindow& reference) {
  assert(reference.full() && reference.ahead().rows() == gains_.preview.size());
  error_sum_ += cart_.C * x_ - reference.now().transpose();
  const Eigen::RowVector2d jerk =
      -gains_.integral * error_sum_ - gains_.state * x_ - gains_.preview.transpose() * reference.ahead();
  x_ = (cart_.A * x_ + cart_.B * jerk).eval();
}

void PreviewWindow::push(const Eigen::Vector2d& latest) {
  assert(!full());
  values_.row(filled_++) = latest;
}

void PreviewWindow::pop() {
  const Eigen::Index rest = values_.rows() - 1;
  values_.topRows(rest) = values_.bottomRows(rest).eval();
  --filled_;
}

SecondPreview::SecondPreview(const Robot& robot, WholeBody model, const CartTable& cart,
                             const PreviewGains& gains)
    : robot_(robot),
      model_(std::move(model)),
      horizon_(static_cast<int>(gains.preview.size())),
      errors_(horizon_),
      control_(cart, gains, Eigen::Vector2d::Zero()),
      pose_{{}, robot.posture} {}

void SecondPreview::push(const Reference& planned) {
  const BodyPose pose = pose_of(robot_, planned, pose_.q);
  if (planned_.empty()) pose_ = pose;
  const BodyMomentum momentum = model_(motion_between(pose_, pose));
  if (!planned_.empty()) {
    // The constant error of standing (the model's center of mass differs from the plan's) fades in over a
    // preview, so that the walk starts in the start posture.
    const Eigen::Vector2d error = planned_.back().zmp_reference - multibody_zmp(momentum_, momentum);
    const double share = quintic_blend(std::min(1.0, static_cast<double>(errors_pushed_++) / horizon_));
    errors_.push(share * error);
  }
  pose_ = pose;
  momentum_ = momentum;
  planned_.push_back(planned);
}

/// The state shifts the waist, and the center of mass with it.
Reference SecondPreview::pop() {
  Reference reference = planned_.front();
  const auto horizontal = [&](int row) {
    return Eigen::Vector3d(control_.state()(row, 0), control_.state()(row, 1), 0);
  };
  reference.com += horizontal(0);
  reference.com_velocity += horizontal(1);
  reference.com_acceleration += horizontal(2);
  reference.zmp += control_.zmp();
  reference.X_PB.translation() += horizontal(0);
  reference.waist_velocity += horizontal(1);
  control_.advance(errors_);
  errors_.pop();
  planned_.pop_front();
  return reference;
}

}  // namespace walking
