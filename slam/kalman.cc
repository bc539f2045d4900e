#include "slam/kalman.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace slam {
namespace {

constexpr int kRoomToGrow = 96, kMoreRows = 32;  // parameters, measurement rows

}  // namespace

void make_room(Eigen::MatrixXd& storage, int rows, int columns) {
  if (rows <= storage.rows() && columns <= storage.cols()) return;
  const auto with_room = [](Eigen::Index now, int needed) {
    return needed <= now ? now : needed + std::max(kMoreRows, needed / 2);
  };
  storage.resize(with_room(storage.rows(), rows), with_room(storage.cols(), columns));
}

void Joint::resize(int state_size, int row_count) {
  size = state_size;
  rows = row_count;
  if (rows > storage_innovation.size()) storage_innovation.resize(rows + kMoreRows);
  make_room(storage_H_robot, rows, kRobot);
  make_room(storage_PHt, size, rows);
  make_room(storage_S, rows, rows);
}

Kalman::Kalman(const RobotVector& x, const RobotMatrix& P, bool observability_constrained)
    : observability_constrained_(observability_constrained) {
  state_.storage_x = x;
  state_.storage_P = P;
  state_.storage_null = robot_null_yaw(x);
  robot_columns_.resize(kRobot, kRobot);
}

void Kalman::predict(const RobotVector& f, const RobotMatrix& F, const RobotMatrix& Q) {
  RobotMatrix A = F;
  const RobotVector after = robot_null_yaw(f);
  if (observability_constrained_) {  // A N = N⁺, Hesch et al. 2013
    const RobotVector before = state_.storage_null.head<kRobot>();
    RobotVector direction = before;
    direction.segment<3>(kPosition).setZero();  // leaves the three translations as they are
    A -= (F * before - after) * direction.transpose() / direction.dot(before);
  }
  state_.storage_x.head<kRobot>() = f;
  state_.storage_null.head<kRobot>() = after;
  const int rest = state_.size - kRobot;
  auto& P = state_.storage_P;
  P.topLeftCorner<kRobot, kRobot>() = A * state_.marginal<kRobot>(0) * A.transpose() + Q;
  auto cross = P.block(kRobot, 0, rest, kRobot);
  auto before = robot_columns_.topRows(rest);
  before = cross;
  cross.noalias() = before * A.transpose();
}

void Kalman::constrain(Measurement& m) const {
  if (!observability_constrained_) return;
  RobotVector n = state_.storage_null.head<kRobot>();
  const int count = static_cast<int>(m.H_landmark.cols());
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> n_landmark =
      state_.storage_null.segment(m.landmark_at, count);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> turned = m.H_robot * n;
  if (count > 0) {
    turned += m.H_landmark * n_landmark;
    const Eigen::Vector3d middle = (n.head<3>() + n_landmark.head<3>()) / 2;
    n.head<3>() -= middle;  // orthogonal to the translations, which H leaves alone already
    n_landmark.head<3>() -= middle;
  } else {
    n.head<3>().setZero();
  }
  const double length = n.squaredNorm() + n_landmark.squaredNorm();
  m.H_robot -= turned * n.transpose() / length;
  if (count > 0) m.H_landmark -= turned * n_landmark.transpose() / length;
}

Measurement::Small<3, 3> Kalman::innovation_covariance(const Measurement& m) const {
  const auto& P = state_.storage_P;
  const auto P_robot = P.topLeftCorner<kRobot, kRobot>().selfadjointView<Eigen::Lower>();
  const Measurement::Small<3, kRobot> HP_robot = m.H_robot * P_robot;
  Measurement::Small<3, 3> S = m.R;
  S.noalias() += HP_robot * m.H_robot.transpose();
  const int count = static_cast<int>(m.H_landmark.cols());
  if (count == 0) return S;
  const Measurement::Small<3, 6> cross = m.H_robot * P.block(m.landmark_at, 0, count, kRobot).transpose();
  const Measurement::Small<3, 3> both = cross * m.H_landmark.transpose();
  const Measurement::Small<3, 6> own =
      m.H_landmark * P.block(m.landmark_at, m.landmark_at, count, count).selfadjointView<Eigen::Lower>();
  S += both + both.transpose();
  S.noalias() += own * m.H_landmark.transpose();
  return S;
}

double Kalman::nis(const Measurement& m) const {
  const Eigen::LLT<Measurement::Small<3, 3>> llt(innovation_covariance(m));
  if (llt.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return llt.matrixL().solve(m.innovation).squaredNorm();
}

double Kalman::log_determinant(const Measurement& m) const {
  return std::log(innovation_covariance(m).determinant());
}

void Kalman::stack(const std::vector<Measurement>& measurements, Joint& joint) const {
  joint.first_row.assign(1, 0);
  for (const Measurement& m : measurements) joint.first_row.push_back(joint.first_row.back() + m.rows);
  joint.resize(state_.size, joint.first_row.back());
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const Measurement& m = measurements[i];
    joint.innovation().segment(joint.first_row[i], m.rows) = m.innovation;
    joint.H_robot().middleRows(joint.first_row[i], m.rows) = m.H_robot;
  }
  const int rest = state_.size - kRobot;
  joint.PHt().topRows<kRobot>().noalias() = state_.marginal<kRobot>(0) * joint.H_robot().transpose();
  joint.PHt().bottomRows(rest).noalias() =
      state_.storage_P.block(kRobot, 0, rest, kRobot) * joint.H_robot().transpose();
  for (std::size_t i = 0; i < measurements.size(); ++i)
    add_landmark_part(measurements[i], joint.PHt().middleCols(joint.first_row[i], measurements[i].rows));
  joint.S().noalias() = joint.H_robot() * joint.PHt().topRows<kRobot>();
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const Measurement& m = measurements[i];
    const int count = static_cast<int>(m.H_landmark.cols());
    auto S_rows = joint.S().middleRows(joint.first_row[i], m.rows);
    if (count > 0) S_rows += m.H_landmark.lazyProduct(joint.PHt().middleRows(m.landmark_at, count));
    S_rows.middleCols(joint.first_row[i], m.rows) += m.R;
  }
}

/// Adds to PHᵀ what the measurement's landmark brings, from the lower triangle of P.
void Kalman::add_landmark_part(const Measurement& m, Eigen::Ref<Eigen::MatrixXd> PHt) const {
  const auto& P = state_.storage_P;
  const int at = m.landmark_at, count = static_cast<int>(m.H_landmark.cols());
  if (count == 0) return;
  const int below = state_.size - at - count;
  PHt.topRows(at) += P.block(at, 0, count, at).transpose().lazyProduct(m.H_landmark.transpose());
  const Measurement::Small<6, 3> own =
      P.block(at, at, count, count).selfadjointView<Eigen::Lower>() * m.H_landmark.transpose();
  PHt.middleRows(at, count) += own;
  for (int k = 0; k < count; ++k)
    for (int row = 0; row < m.rows; ++row)
      PHt.col(row).tail(below) += m.H_landmark(row, k) * P.col(at + k).segment(at + count, below);
}

bool Kalman::update(const Joint& joint) {
  make_room(L_, joint.rows, joint.rows);
  make_room(W_, joint.size, joint.rows);
  if (joint.rows > white_.size()) white_.resize(joint.rows + kMoreRows);
  auto L = L_.topLeftCorner(joint.rows, joint.rows);
  L = joint.S();
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(L);
  if (llt.info() != Eigen::Success || !joint.innovation().allFinite()) return false;
  const int size = state_.size;
  auto W = W_.topLeftCorner(size, joint.rows);
  W = joint.PHt();
  llt.matrixU().solveInPlace<Eigen::OnTheRight>(W);  // W = PHᵀ L⁻ᵀ
  auto white = white_.head(joint.rows);
  white = joint.innovation();
  llt.matrixL().solveInPlace(white);
  state_.storage_x.head(size).noalias() += W * white;
  state_.storage_P.topLeftCorner(size, size).selfadjointView<Eigen::Lower>().rankUpdate(W, -1);
  normalise_orientation();
  return true;
}

void Kalman::normalise_orientation() {
  const Eigen::Vector4d q = state_.orientation();
  const Eigen::Matrix4d N = normalised_jacobian(q);  // symmetric
  auto& P = state_.storage_P;
  state_.storage_x.segment<4>(kOrientation) = q.normalized();
  state_.storage_null.segment<4>(kOrientation) = (N * state_.storage_null.segment<4>(kOrientation)).eval();
  P.block<4, kOrientation>(kOrientation, 0) = (N * P.block<4, kOrientation>(kOrientation, 0)).eval();
  P.block<4, 4>(kOrientation, kOrientation) = N * state_.marginal<4>(kOrientation) * N;
  for (int row = kOrientation + 4; row < state_.size; ++row)
    P.block<1, 4>(row, kOrientation) = (P.block<1, 4>(row, kOrientation) * N).eval();
}

void Kalman::reserve(int size) {
  if (size <= state_.storage_x.size()) return;
  const int room = size + std::max(kRoomToGrow, size / 2);
  state_.storage_x.conservativeResize(room);
  state_.storage_null.conservativeResize(room);
  state_.storage_P.conservativeResize(room, room);
  robot_columns_.resize(room, kRobot);
}

int Kalman::append(const Beginning& beginning) {
  const int at = state_.size;
  reserve(at + 6);
  state_.size += 6;
  state_.storage_x.segment<6>(at) = beginning.y;
  state_.storage_null.segment<6>(at) = beginning.J_robot * state_.storage_null.head<kRobot>();
  auto& P = state_.storage_P;
  P.block<6, kRobot>(at, 0) = beginning.J_robot * state_.marginal<kRobot>(0);
  P.block(at, kRobot, 6, at - kRobot).noalias() =
      beginning.J_robot * P.block(kRobot, 0, at - kRobot, kRobot).transpose();
  P.block<6, 6>(at, at) = P.block<6, kRobot>(at, 0) * beginning.J_robot.transpose() + beginning.noise;
  return at;
}

void Kalman::replace(int at, int before, const Eigen::Ref<const Eigen::VectorXd>& y,
                     const Eigen::Ref<const Eigen::MatrixXd>& J) {
  const int now = static_cast<int>(y.size());
  const int below = state_.size - at - before;
  auto& P = state_.storage_P;
  for (int column = 0; column < at; ++column)
    P.block(at, column, now, 1) = Parameters(J * P.block(at, column, before, 1));
  const ParameterJacobian JP = J * P.block(at, at, before, before).selfadjointView<Eigen::Lower>();
  P.block(at, at, now, now).noalias() = JP * J.transpose();
  for (int row = at + before; row < at + before + below; ++row)
    P.block(row, at, 1, now) = Parameters(J * P.block(row, at, 1, before).transpose()).transpose();
  state_.storage_null.segment(at, now) = Parameters(J * state_.storage_null.segment(at, before));
  state_.storage_x.segment(at, now) = y;
  erase(at + now, before - now);
}

void Kalman::blur(int at, const Eigen::Matrix3d& Q) { state_.storage_P.block<3, 3>(at, at) += Q; }

int Kalman::append_known(const Eigen::Vector3d& p_W, double sigma_m) {
  const int at = state_.size;
  reserve(at + 3);
  state_.size += 3;
  state_.storage_x.segment<3>(at) = p_W;
  state_.storage_null.segment<3>(at) = Eigen::Vector3d::UnitZ().cross(p_W);
  state_.storage_P.block(at, 0, 3, at + 3).setZero();
  blur(at, sigma_m * sigma_m * Eigen::Matrix3d::Identity());
  return at;
}

void Kalman::erase(int at, int count) {
  const int size = state_.size;
  auto& P = state_.storage_P;
  for (int column = 0; column < size - count; ++column) {
    const int from = column < at ? column : column + count;  // its lower part, from row max(at, column) on
    const double* const old = P.col(from).data();
    std::copy(old + std::max(at + count, from), old + size, P.col(column).data() + std::max(at, column));
  }
  for (auto* values : {&state_.storage_x, &state_.storage_null})
    std::copy(values->data() + at + count, values->data() + size, values->data() + at);
  state_.size -= count;
}

void Kalman::restart(const RobotVector& x, const RobotMatrix& P) {
  state_.storage_x.head<kRobot>() = x;
  state_.storage_null.head<kRobot>() = robot_null_yaw(x);
  state_.storage_P.block(kRobot, 0, state_.size - kRobot, kRobot).setZero();
  state_.storage_P.topLeftCorner<kRobot, kRobot>() = P;
}

bool Kalman::sound(int count) {
  constexpr double kRounding = 1e-9;
  const auto variances = state_.storage_P.diagonal().head(state_.size);
  if (!state_.x().allFinite() || !variances.allFinite() || variances.minCoeff() < -1e-12) return false;
  make_room(scaled_, count, count);
  auto C = scaled_.topLeftCorner(count, count);
  const auto scale = [&](int i) { return variances(i) > 0 ? 1 / std::sqrt(variances(i)) : 0; };
  for (int column = 0; column < count; ++column) {
    for (int row = column + 1; row < count; ++row)
      C(row, column) = state_.storage_P(row, column) * scale(row) * scale(column);
    C(column, column) = 1 + kRounding;
  }
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(C);
  return llt.info() == Eigen::Success;
}

}  // namespace slam
