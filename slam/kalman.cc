#include "slam/kalman.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

namespace slam {
namespace {

constexpr int kRoomToGrow = 96;  // parameters

/// The symmetric matrix' upper triangle from its lower one.
template <typename Matrix>
void mirror(Matrix&& P) {
  P.template triangularView<Eigen::StrictlyUpper>() = P.transpose();
}

}  // namespace

Kalman::Kalman(const RobotVector& x, const RobotMatrix& P, bool observability_constrained)
    : observability_constrained_(observability_constrained) {
  state_.storage_x = x;
  state_.storage_P = P;
  state_.storage_null = robot_null_yaw(x);
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
  auto P = state_.storage_P.topLeftCorner(state_.size, state_.size);
  const RobotMatrix P_robot = A * P.topLeftCorner<kRobot, kRobot>() * A.transpose() + Q;
  P.topLeftCorner<kRobot, kRobot>() = P_robot;
  P.topRightCorner(kRobot, rest) = (A * P.topRightCorner(kRobot, rest)).eval();
  P.bottomLeftCorner(rest, kRobot) = P.topRightCorner(kRobot, rest).transpose();
  mirror(P.topLeftCorner<kRobot, kRobot>());
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
  const auto P_robot = state_.storage_P.topLeftCorner<kRobot, kRobot>();
  Measurement::Small<3, kRobot> HP = m.H_robot * P_robot;
  Measurement::Small<3, 3> S = m.R;
  const int count = static_cast<int>(m.H_landmark.cols());
  if (count > 0) {
    const auto P_cross = state_.storage_P.block(m.landmark_at, 0, count, kRobot);
    const Measurement::Small<3, 6> HP_landmark =
        m.H_robot * P_cross.transpose() +
        m.H_landmark * state_.storage_P.block(m.landmark_at, m.landmark_at, count, count);
    HP += m.H_landmark * P_cross;
    S += HP_landmark * m.H_landmark.transpose();
  }
  return S + HP * m.H_robot.transpose();
}

double Kalman::nis(const Measurement& m) const {
  const Eigen::LLT<Measurement::Small<3, 3>> llt(innovation_covariance(m));
  if (llt.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return llt.matrixL().solve(m.innovation).squaredNorm();
}

void Kalman::stack(const std::vector<Measurement>& measurements, Joint& joint) const {
  joint.first_row.assign(1, 0);
  for (const Measurement& m : measurements) joint.first_row.push_back(joint.first_row.back() + m.rows);
  const int rows = joint.first_row.back();
  const int size = state_.size;
  joint.innovation.resize(rows);
  joint.PHt.resize(size, rows);
  joint.S.resize(rows, rows);
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const Measurement& m = measurements[i];
    const int count = static_cast<int>(m.H_landmark.cols());
    auto columns = joint.PHt.middleCols(joint.first_row[i], m.rows);
    columns.noalias() = state_.storage_P.topLeftCorner(size, kRobot) * m.H_robot.transpose();
    if (count > 0)
      columns.noalias() += state_.storage_P.block(0, m.landmark_at, size, count) * m.H_landmark.transpose();
    joint.innovation.segment(joint.first_row[i], m.rows) = m.innovation;
  }
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const Measurement& m = measurements[i];
    const int count = static_cast<int>(m.H_landmark.cols());
    auto S_rows = joint.S.middleRows(joint.first_row[i], m.rows);
    S_rows.noalias() = m.H_robot * joint.PHt.topRows(kRobot);
    if (count > 0) S_rows.noalias() += m.H_landmark * joint.PHt.middleRows(m.landmark_at, count);
    S_rows.middleCols(joint.first_row[i], m.rows) += m.R;
  }
}

bool Kalman::update(const Joint& joint) {
  const Eigen::LLT<Eigen::MatrixXd> llt(joint.S);
  if (llt.info() != Eigen::Success || !joint.innovation.allFinite()) return false;
  const int size = state_.size;
  W_ = joint.PHt;
  llt.matrixU().solveInPlace<Eigen::OnTheRight>(W_);  // W = PHᵀ L⁻ᵀ
  state_.storage_x.head(size).noalias() += W_ * llt.matrixL().solve(joint.innovation);
  auto P = state_.storage_P.topLeftCorner(size, size);
  P.selfadjointView<Eigen::Lower>().rankUpdate(W_, -1);
  mirror(P);
  normalise_orientation();
  return true;
}

void Kalman::normalise_orientation() {
  const Eigen::Vector4d q = state_.orientation();
  const Eigen::Matrix4d N = normalised_jacobian(q);
  const int size = state_.size;
  auto P = state_.storage_P.topLeftCorner(size, size);
  state_.storage_x.segment<4>(kOrientation) = q.normalized();
  state_.storage_null.segment<4>(kOrientation) = (N * state_.storage_null.segment<4>(kOrientation)).eval();
  P.middleCols<4>(kOrientation) = (P.middleCols<4>(kOrientation) * N.transpose()).eval();
  const Eigen::Matrix4d P_qq = N * P.block<4, 4>(kOrientation, kOrientation);
  P.middleRows<4>(kOrientation) = P.middleCols<4>(kOrientation).transpose();
  P.block<4, 4>(kOrientation, kOrientation) = P_qq;
  mirror(P.block<4, 4>(kOrientation, kOrientation));
}

void Kalman::reserve(int size) {
  if (size <= state_.storage_x.size()) return;
  const int room = size + kRoomToGrow;
  state_.storage_x.conservativeResize(room);
  state_.storage_null.conservativeResize(room);
  state_.storage_P.conservativeResize(room, room);
}

int Kalman::append(const Beginning& beginning) {
  const int at = state_.size;
  reserve(at + 6);
  state_.size += 6;
  state_.storage_x.segment<6>(at) = beginning.y;
  state_.storage_null.segment<6>(at) = beginning.J_robot * state_.storage_null.head<kRobot>();
  auto& P = state_.storage_P;
  P.block(at, 0, 6, at).noalias() = beginning.J_robot * P.block(0, 0, kRobot, at);
  P.block(0, at, at, 6) = P.block(at, 0, 6, at).transpose();
  P.block<6, 6>(at, at) = beginning.J_robot * P.block(0, at, kRobot, 6) + beginning.noise;
  mirror(P.block<6, 6>(at, at));
  return at;
}

void Kalman::replace(int at, int before, const Eigen::VectorXd& y, const Eigen::MatrixXd& J) {
  const int now = static_cast<int>(y.size());
  const int size = state_.size;
  auto& P = state_.storage_P;
  P.block(at, 0, now, size) = (J * P.block(at, 0, before, size)).eval();
  P.block(0, at, size, now) = (P.block(0, at, size, before) * J.transpose()).eval();
  mirror(P.block(at, at, now, now));
  state_.storage_null.segment(at, now) = (J * state_.storage_null.segment(at, before)).eval();
  state_.storage_x.segment(at, now) = y;
  erase(at + now, before - now);
}

void Kalman::erase(int at, int count) {
  const int rest = state_.size - at - count;
  const int size = state_.size;
  auto& P = state_.storage_P;
  for (int column = 0; column < size; ++column) {
    double* const begin = P.col(column).data();
    std::copy(begin + at + count, begin + size, begin + at);
  }
  for (int column = at; column < at + rest; ++column)
    P.col(column).head(size - count) = P.col(column + count).head(size - count);
  for (auto* values : {&state_.storage_x, &state_.storage_null})
    std::copy(values->data() + at + count, values->data() + size, values->data() + at);
  state_.size -= count;
}

bool Kalman::sound() const {
  return state_.x().allFinite() && state_.P().diagonal().allFinite() &&
         state_.P().diagonal().minCoeff() >= -1e-12;
}

}  // namespace slam
