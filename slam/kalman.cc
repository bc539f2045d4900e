#include "slam/kalman.h"

#include <algorithm>
#include <cmath>

#include "slam/eigen_kernels.h"

namespace slam {
namespace {

constexpr int kSpareParameters = 96;
constexpr int kPanel = 12;  // columns solved one by one; all earlier ones are subtracted in one product

/// W ← WL⁻ᵀ. Eigen's solver is several times slower for many rows and few columns.
template <class Lower>
void solve_transposed(const Lower& L, Eigen::Ref<Eigen::MatrixXd> W) {
  for (Eigen::Index begin = 0; begin < W.cols(); begin += kPanel) {
    const Eigen::Index end = std::min(begin + kPanel, W.cols()), width = end - begin;
    if (begin > 0)
      W.middleCols(begin, width).noalias() -= W.leftCols(begin) * L.block(begin, 0, width, begin).transpose();
    for (Eigen::Index j = begin; j < end; ++j) {
      for (Eigen::Index k = begin; k < j; ++k) W.col(j) -= L(j, k) * W.col(k);
      W.col(j) *= 1 / L(j, j);
    }
  }
}

}  // namespace

RobotVector robot_null_yaw(const RobotVector& x) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  RobotVector n = RobotVector::Zero();
  n.segment<3>(kPosition) = up.cross(x.segment<3>(kPosition));
  n.segment<4>(kOrientation) =
      0.5 * quaternion_product(Eigen::Vector4d(0, 0, 0, 1), x.segment<4>(kOrientation));
  n.segment<3>(kVelocity) = up.cross(x.segment<3>(kVelocity));
  return n;
}

Kalman::Kalman(const RobotState& initial, bool observability_constrained, int match_biases)
    : observability_constrained_(observability_constrained) {
  state_.size = kRobot + 2 * match_biases;
  for (auto* values : {&state_.storage_x, &state_.storage_null}) values->setZero(state_.size);
  state_.storage_sensitivity.setZero(state_.size, kSystematicErrors);
  state_.storage_P.setZero(state_.size, state_.size);
  state_.storage_x.head<kRobot>() = initial.x;
  state_.storage_P.topLeftCorner<kRobot, kRobot>() = initial.P;
  state_.storage_null.head<kRobot>() = robot_null_yaw(initial.x);
  robot_columns_.resize(state_.size, kRobot);
}

void Kalman::predict(const RobotVector& f, const RobotMatrix& F, const RobotMatrix& Q) {
  RobotMatrix A = F;
  const RobotVector after = robot_null_yaw(f);
  if (observability_constrained_) {  // A N = N⁺, Hesch et al. 2013
    const RobotVector before = state_.storage_null.head<kRobot>();
    RobotVector direction = before;
    direction.segment<3>(kPosition).setZero();  // the columns of the translations stay as they are
    A -= (F * before - after) * direction.transpose() / direction.dot(before);
  }
  if (smoother_) smoother_->change(0, A);
  state_.storage_x.head<kRobot>() = f;
  state_.storage_null.head<kRobot>() = after;
  const Eigen::Matrix<double, kRobot, kSystematicErrors> sensitivity =
      state_.storage_sensitivity.topRows<kRobot>();
  multiply(F, sensitivity, state_.storage_sensitivity.topRows(kRobot));
  const int rest = state_.size - kRobot;
  auto& P = state_.storage_P;
  RobotMatrix AP;
  multiply(A, state_.marginal<kRobot>(0), AP);
  multiply_transposed(AP, A, P.topLeftCorner(kRobot, kRobot));
  P.topLeftCorner(kRobot, kRobot) += Q;
  auto before = robot_columns_.topRows(rest);
  before = P.block(kRobot, 0, rest, kRobot);
  for (int row = 0; row < kRobot; ++row) {  // A is sparse
    auto after_row = P.col(row).segment(kRobot, rest);
    after_row = A(row, row) * before.col(row);
    for (int k = 0; k < kRobot; ++k)
      if (k != row && A(row, k) != 0) after_row += A(row, k) * before.col(k);
  }
}

void Kalman::constrain(Measurement& m) const {
  if (!observability_constrained_) return;
  Eigen::Matrix<double, kRate, 1> n = state_.storage_null.head<kRate>();  // the others are zero
  auto H_robot = m.H_robot.leftCols<kRate>();
  const int count = static_cast<int>(m.H_landmark.cols());
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> n_landmark =
      state_.storage_null.segment(m.landmark_at, count);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> turned = H_robot.lazyProduct(n);
  if (count > 0) {
    turned += m.H_landmark.lazyProduct(n_landmark);
    const Eigen::Vector3d middle = (n.head<3>() + n_landmark.head<3>()) / 2;
    n.head<3>() -= middle;  // keeps the translations in the null space of H
    n_landmark.head<3>() -= middle;
  } else {
    n.head<3>().setZero();
  }
  const double length = n.squaredNorm() + n_landmark.squaredNorm();
  H_robot -= turned * n.transpose() / length;
  if (count > 0) m.H_landmark -= turned * n_landmark.transpose() / length;
}

bool Kalman::update(const StackedMeasurement& stacked) {
  if (!whitening_.compute(stacked)) return false;
  const int size = state_.size;
  reserve_workspace(W_, size, stacked.rows);
  auto W = W_.topLeftCorner(size, stacked.rows);
  W = stacked.PHt();
  solve_transposed(whitening_.L(), W);  // PHᵀL⁻ᵀ
  if (smoother_) smoother_->update(stacked, whitening_, W);
  subtract_square(W);
  W.middleRows(considered_.first, considered_.second - considered_.first).setZero();
  state_.storage_x.head(size).noalias() += W * whitening_.innovation();
  update_sensitivity(stacked);
  normalize_orientation();
  return true;
}

/// P ← P − WWᵀ except for the covariance of the considered parameters.
void Kalman::subtract_square(const Eigen::Ref<const Eigen::MatrixXd>& W) {
  auto& P = state_.storage_P;
  const auto subtract = [&](int at, int count) {
    P.block(at, at, count, count).selfadjointView<Eigen::Lower>().rankUpdate(W.middleRows(at, count), -1);
  };
  const auto [begin, end] = considered_;
  if (begin == end) return subtract(0, state_.size);
  const int rest = state_.size - begin, later = state_.size - end;
  subtract(0, begin);
  subtract(end, later);
  P.block(begin, 0, rest, begin).noalias() -= W.bottomRows(rest) * W.topRows(begin).transpose();
  P.block(end, begin, later, end - begin).noalias() -=
      W.bottomRows(later) * W.middleRows(begin, end - begin).transpose();
}

/// The state's derivative with respect to the systematic errors is updated like the state itself.
void Kalman::update_sensitivity(const StackedMeasurement& stacked) {
  if (stacked.rows > sensitivity_.rows())
    sensitivity_.resize(stacked.storage_sensitivity.rows(), kSystematicErrors);
  auto U = sensitivity_.topRows(stacked.rows);
  U = stacked.sensitivity();
  whitening_.solve(U);
  const auto W = W_.topLeftCorner(state_.size, stacked.rows);
  for (int k = 0; k < kSystematicErrors; ++k) {
    SystematicEvidence& evidence = evidence_[static_cast<std::size_t>(k)];
    evidence.score += U.col(k).dot(whitening_.innovation());
    evidence.information += U.col(k).squaredNorm();
    state_.storage_sensitivity.col(k).head(state_.size).noalias() += W * U.col(k);
  }
}

void Kalman::normalize_orientation() {
  const Eigen::Vector4d q = state_.orientation();
  const Eigen::Matrix4d N = normalized_jacobian(q);  // symmetric
  if (smoother_) smoother_->change(kOrientation, N);
  auto& P = state_.storage_P;
  state_.storage_x.segment<4>(kOrientation) = q.normalized();
  auto& s = state_.storage_sensitivity;
  state_.storage_null.segment<4>(kOrientation) = (N * state_.storage_null.segment<4>(kOrientation)).eval();
  s.middleRows<4>(kOrientation) = (N * s.middleRows<4>(kOrientation)).eval();
  P.block<4, kOrientation>(kOrientation, 0) = (N * P.block<4, kOrientation>(kOrientation, 0)).eval();
  P.block<4, 4>(kOrientation, kOrientation) = N * state_.marginal<4>(kOrientation) * N;
  for (int row = kOrientation + 4; row < state_.size; ++row)
    P.block<1, 4>(row, kOrientation) = (P.block<1, 4>(row, kOrientation) * N).eval();
}

void Kalman::reserve(int size) {
  if (size <= state_.storage_x.size()) return;
  const int room = size + std::max(kSpareParameters, size / 2);
  for (auto* values : {&state_.storage_x, &state_.storage_null}) values->conservativeResize(room);
  state_.storage_sensitivity.conservativeResize(room, kSystematicErrors);
  state_.storage_P.conservativeResize(room, room);
  robot_columns_.resize(room, kRobot);
}

int Kalman::append(const LandmarkInitialization& landmark) {
  const int at = state_.size;
  reserve(at + 6);
  state_.size += 6;
  state_.storage_x.segment<6>(at) = landmark.y;
  state_.storage_null.segment<6>(at) = landmark.J_robot * state_.storage_null.head<kRobot>();
  auto& s = state_.storage_sensitivity;
  multiply(landmark.J_robot, s.topRows(kRobot), s.middleRows(at, 6));
  s.col(kLensDistortion).segment<6>(at) += landmark.distortion;
  auto& P = state_.storage_P;
  multiply(landmark.J_robot, state_.marginal<kRobot>(0), P.block(at, 0, 6, kRobot));
  multiply_transposed(landmark.J_robot, P.block(kRobot, 0, at - kRobot, kRobot),
                      P.block(at, kRobot, 6, at - kRobot));
  multiply_transposed(P.block(at, 0, 6, kRobot), landmark.J_robot, P.block(at, at, 6, 6));
  P.block(at, at, 6, 6) += landmark.noise;
  if (smoother_) smoother_->append(at, landmark.J_robot);
  return at;
}

void Kalman::replace(int at, int count, const Eigen::Ref<const Eigen::VectorXd>& y,
                     const Eigen::Ref<const Eigen::MatrixXd>& J) {
  const int new_count = static_cast<int>(y.size());
  auto& P = state_.storage_P;
  for (int column = 0; column < at; ++column)
    P.block(at, column, new_count, 1) = Parameters(J * P.block(at, column, count, 1));
  const ParameterJacobian JP = J * P.block(at, at, count, count).selfadjointView<Eigen::Lower>();
  P.block(at, at, new_count, new_count).noalias() = JP * J.transpose();
  for (int row = at + count; row < state_.size; ++row)
    P.block(row, at, 1, new_count) = Parameters(J * P.block(row, at, 1, count).transpose()).transpose();
  const auto replace_in = [&](auto&& values) {
    values.segment(at, new_count) = Parameters(J * values.segment(at, count));
  };
  replace_in(state_.storage_null);
  for (int k = 0; k < kSystematicErrors; ++k) replace_in(state_.storage_sensitivity.col(k));
  state_.storage_x.segment(at, new_count) = y;
  ParameterJacobian square = ParameterJacobian::Zero(count, count);
  square.topRows(new_count) = J;
  if (smoother_) smoother_->change(at, square);
  erase(at + new_count, count - new_count);
}

void Kalman::predict_match_bias(int at, double decay, double variance) {
  if (smoother_) smoother_->change(at, decay * Eigen::Matrix2d::Identity());
  auto& P = state_.storage_P;
  P.block(at, 0, 2, at) *= decay;
  P.block(at + 2, at, state_.size - at - 2, 2) *= decay;
  P.block<2, 2>(at, at) *= decay * decay;
  P.block<2, 2>(at, at).diagonal().array() += variance;
  state_.storage_x.segment<2>(at) *= decay;
  state_.storage_sensitivity.middleRows<2>(at) *= decay;
}

void Kalman::inflate(int at, const Eigen::Matrix3d& Q) { state_.storage_P.block<3, 3>(at, at) += Q; }

int Kalman::append_point(const Eigen::Vector3d& p_W, double sigma_m) {
  const int at = state_.size;
  reserve(at + 3);
  state_.size += 3;
  state_.storage_x.segment<3>(at) = p_W;
  state_.storage_null.segment<3>(at) = Eigen::Vector3d::UnitZ().cross(p_W);
  state_.storage_sensitivity.middleRows<3>(at).setZero();
  state_.storage_P.block(at, 0, 3, at + 3).setZero();
  inflate(at, sigma_m * sigma_m * Eigen::Matrix3d::Identity());
  if (smoother_) smoother_->append(at, Eigen::MatrixXd(3, 0));
  return at;
}

int Kalman::append_map(const Eigen::VectorXd& x, const Eigen::MatrixXd& P, const Eigen::VectorXd& null_yaw) {
  const int at = state_.size, count = static_cast<int>(x.size());
  reserve(at + count);
  state_.size += count;
  state_.storage_x.segment(at, count) = x;
  state_.storage_null.segment(at, count) = null_yaw;
  state_.storage_sensitivity.middleRows(at, count).setZero();
  state_.storage_P.block(at, 0, count, at).setZero();
  state_.storage_P.block(at, at, count, count) = P;
  if (smoother_) smoother_->append(at, Eigen::MatrixXd(count, 0));
  return at;
}

void Kalman::erase(int at, int count) {
  const int size = state_.size;
  auto& P = state_.storage_P;
  for (int column = 0; column < size - count; ++column) {
    // Moves the column's lower part, starting at row max(at, column).
    const int from = column < at ? column : column + count;
    const double* const old = P.col(from).data();
    std::copy(old + std::max(at + count, from), old + size, P.col(column).data() + std::max(at, column));
  }
  if (smoother_) smoother_->change(at, Eigen::MatrixXd(0, count));
  const auto close_gap = [&](double* values) { std::copy(values + at + count, values + size, values + at); };
  close_gap(state_.storage_x.data());
  close_gap(state_.storage_null.data());
  for (int k = 0; k < kSystematicErrors; ++k) close_gap(state_.storage_sensitivity.col(k).data());
  state_.size -= count;
}

void Kalman::reset_robot(const RobotState& robot) {
  if (smoother_) smoother_->change(0, RobotMatrix::Zero());
  state_.storage_x.head<kRobot>() = robot.x;
  state_.storage_null.head<kRobot>() = robot_null_yaw(robot.x);
  state_.storage_sensitivity.setZero();
  state_.storage_P.block(kRobot, 0, state_.size - kRobot, kRobot).setZero();
  state_.storage_P.topLeftCorner<kRobot, kRobot>() = robot.P;
}

bool Kalman::is_valid(int count) {
  constexpr double kRounding = 1e-9;
  const auto variances = state_.storage_P.diagonal().head(state_.size);
  if (!state_.x().allFinite() || !variances.allFinite() || variances.minCoeff() < -1e-12) return false;
  reserve_workspace(scaled_, count, count + 1);
  auto C = scaled_.topLeftCorner(count, count);
  auto scales = scaled_.col(count).head(count);
  for (int i = 0; i < count; ++i) scales(i) = variances(i) > 0 ? 1 / std::sqrt(variances(i)) : 0;
  for (int column = 0; column < count; ++column) {
    const int below = count - column - 1;
    C.col(column).tail(below) =
        state_.storage_P.col(column).segment(column + 1, below).cwiseProduct(scales.tail(below)) *
        scales(column);
    C(column, column) = 1 + kRounding;
  }
  return factorize(C);
}

}  // namespace slam
