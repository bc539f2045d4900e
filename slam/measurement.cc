#include "slam/measurement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "slam/eigen_kernels.h"

template struct Eigen::internal::gebp_kernel<
    double, double, Eigen::Index, Eigen::internal::blas_data_mapper<double, Eigen::Index, Eigen::ColMajor>,
    Eigen::internal::ProductSizes::mr, Eigen::internal::ProductSizes::nr, false, false>;

namespace slam {
namespace {

constexpr int kSpareRows = 32;

/// Adds the part above the landmark's Count parameters.
template <int Count>
void add_above(const Eigen::MatrixXd& P, const Measurement& m, Eigen::Ref<Eigen::MatrixXd> PHt) {
  for (int row = 0; row < m.rows; ++row) {
    const Eigen::Matrix<double, Count, 1> h = m.H_landmark.row(row);
    for (int i = 0; i < m.landmark_at; ++i) PHt(i, row) += h.dot(P.block<Count, 1>(m.landmark_at, i));
  }
}

/// Adds the landmark's columns of P, times its H, to PHᵀ. Only the lower triangle of P is read.
void add_landmark_part(const State& state, const Measurement& m, Eigen::Ref<Eigen::MatrixXd> PHt) {
  const auto& P = state.storage_P;
  const int at = m.landmark_at, count = static_cast<int>(m.H_landmark.cols());
  if (count == 0) return;
  const int below = state.size - at - count;
  if (count == 3)
    add_above<3>(P, m, PHt);
  else
    add_above<6>(P, m, PHt);
  const Measurement::Small<6, 3> own =
      P.block(at, at, count, count).selfadjointView<Eigen::Lower>() * m.H_landmark.transpose();
  PHt.middleRows(at, count) += own;
  for (int k = 0; k < count; ++k)
    for (int row = 0; row < m.rows; ++row)
      PHt.col(row).tail(below) += m.H_landmark(row, k) * P.col(at + k).segment(at + count, below);
}

/// Adds the match bias's columns of P, times its gain, to PHᵀ.
void add_bias_part(const State& state, const Measurement& m, Eigen::Ref<Eigen::MatrixXd> PHt) {
  if (m.bias_at < 0) return;
  const auto& P = state.storage_P;
  for (int row = 0; row < m.rows; ++row) {
    const int at = m.bias_at + row, below = state.size - at;
    PHt.col(row).head(at) += m.bias_gain * P.block(at, 0, 1, at).transpose();
    PHt.col(row).tail(below) += m.bias_gain * P.col(at).segment(at, below);
  }
}

/// Adds to S the contribution of the match bias.
void add_bias_part(const State& state, const Measurement& m, Measurement::Small<3, 3>& S) {
  if (m.bias_at < 0) return;
  const auto& P = state.storage_P;
  const int robot = m.robot_columns;
  Measurement::Small<3, 3> cross =
      m.H_robot.leftCols(robot).lazyProduct(P.middleRows<2>(m.bias_at).leftCols(robot).transpose());
  const int count = static_cast<int>(m.H_landmark.cols());
  if (count > 0)
    cross += m.H_landmark.lazyProduct(P.middleCols<2>(m.bias_at).middleRows(m.landmark_at, count));
  S += m.bias_gain * (cross + cross.transpose());
  S += m.bias_gain * m.bias_gain * state.marginal<2>(m.bias_at);
}

/// Adds to S the contribution of the robot's first Count parameters; H of the others is zero.
template <int Count>
void add_robot_part(const State& state, const Measurement& m, Measurement::Small<3, 3>& S) {
  const Eigen::Matrix<double, Count, Count> P = state.marginal<Count>(0);
  Eigen::Matrix<double, Count, 3> PHt = Eigen::Matrix<double, Count, 3>::Zero();
  for (int row = 0; row < m.rows; ++row)
    for (int k = 0; k < Count; ++k)
      if (m.H_robot(row, k) != 0) PHt.col(row) += m.H_robot(row, k) * P.col(k);
  S += m.H_robot.leftCols<Count>().lazyProduct(PHt.leftCols(m.rows));
}

/// The derivative of the innovation with respect to the systematic errors, which act on the measurement and,
/// through all earlier ones, on the state.
Eigen::Matrix<double, Eigen::Dynamic, kSystematicErrors, 0, 3, kSystematicErrors> innovation_sensitivity(
    const State& state, const Measurement& m) {
  const auto& s = state.storage_sensitivity;
  const int count = static_cast<int>(m.H_landmark.cols());
  auto derivative = m.sensitivity;
  derivative -= m.H_robot.leftCols(m.robot_columns).lazyProduct(s.topRows(m.robot_columns));
  if (count > 0) derivative -= m.H_landmark.lazyProduct(s.middleRows(m.landmark_at, count));
  if (m.bias_at >= 0) derivative -= m.bias_gain * s.middleRows<2>(m.bias_at);
  return derivative;
}

}  // namespace

void multiply(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::MatrixXd>& B,
              Eigen::Ref<Eigen::MatrixXd> C) {
  C.noalias() = A * B;
}

void multiply_transposed(const Eigen::Ref<const Eigen::MatrixXd>& A,
                         const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Ref<Eigen::MatrixXd> C) {
  C.noalias() = A * B.transpose();
}

bool factorize(Eigen::Ref<Eigen::MatrixXd> A) {
  return Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>>(A).info() == Eigen::Success;
}

Measurement::Small<3, 3> innovation_covariance(const State& state, const Measurement& m) {
  const auto& P = state.storage_P;
  Measurement::Small<3, 3> S = m.R;
  if (m.robot_columns == kRate)
    add_robot_part<kRate>(state, m, S);
  else
    add_robot_part<kRobot>(state, m, S);
  add_bias_part(state, m, S);
  const int count = static_cast<int>(m.H_landmark.cols());
  if (count == 0) return S;
  const ParameterJacobian own =
      P.block(m.landmark_at, m.landmark_at, count, count).selfadjointView<Eigen::Lower>();
  const Measurement::Small<3, 6> HP_own = m.H_landmark.lazyProduct(own);
  const Measurement::Small<3, 6> cross =
      m.H_robot.leftCols(m.robot_columns)
          .lazyProduct(P.block(m.landmark_at, 0, count, m.robot_columns).transpose());
  const Measurement::Small<3, 3> both = (cross + cross + HP_own).lazyProduct(m.H_landmark.transpose());
  return S + (both + both.transpose()) / 2;
}

Nis normalized_innovation_squared(const State& state, const Measurement& m,
                                  std::optional<Eigen::Vector3d>* whitened) {
  const Measurement::Small<3, 3> S = innovation_covariance(state, m);
  const Eigen::LLT<Measurement::Small<3, 3>> llt(S);
  Nis nis{std::numeric_limits<double>::infinity(), m.rows};
  std::optional<Eigen::Vector3d> now;
  if (llt.info() == Eigen::Success) {
    now = Eigen::Vector3d::Zero();
    now->head(m.rows) = llt.matrixL().solve(m.innovation);
    nis.value = now->squaredNorm();
    nis.log_determinant = 2 * llt.matrixLLT().diagonal().array().log().sum();
  }
  if (!whitened) return nis;
  if (now && *whitened) nis.lagged = now->dot(**whitened), nis.lagged_square = nis.value;
  *whitened = now;
  return nis;
}

void reserve_workspace(Eigen::MatrixXd& storage, int rows, int columns) {
  if (rows <= storage.rows() && columns <= storage.cols()) return;
  const auto with_room = [](Eigen::Index now, int needed) {
    return needed <= now ? now : needed + std::max(kSpareRows, needed / 2);
  };
  storage.resize(with_room(storage.rows(), rows), with_room(storage.cols(), columns));
}

void StackedMeasurement::resize(int state_size, int row_count) {
  size = state_size;
  rows = row_count;
  if (rows > storage_innovation.size()) storage_innovation.resize(rows + kSpareRows);
  if (rows > storage_sensitivity.rows()) storage_sensitivity.resize(rows + kSpareRows, kSystematicErrors);
  reserve_workspace(storage_H_robot, rows, kRobot);
  reserve_workspace(storage_PHt, size, rows);
  reserve_workspace(storage_S, rows, rows);
}

void stack(const State& state, const std::vector<Measurement>& measurements, StackedMeasurement& stacked) {
  stacked.first_row.assign(1, 0);
  for (const Measurement& m : measurements) stacked.first_row.push_back(stacked.first_row.back() + m.rows);
  stacked.resize(state.size, stacked.first_row.back());
  stacked.blocks.clear();
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const Measurement& m = measurements[i];
    if (m.H_landmark.cols() > 0) stacked.blocks.push_back({i, m.landmark_at, m.H_landmark});
    if (m.bias_at >= 0)
      stacked.blocks.push_back(
          {i, m.bias_at, m.bias_gain * Measurement::Small<3, 6>::Identity(m.rows, m.rows)});
    stacked.innovation().segment(stacked.first_row[i], m.rows) = m.innovation;
    stacked.H_robot().middleRows(stacked.first_row[i], m.rows) = m.H_robot;
    stacked.sensitivity().middleRows(stacked.first_row[i], m.rows) = innovation_sensitivity(state, m);
  }
  const int rest = state.size - kRobot;
  int robot = 0;
  for (const Measurement& m : measurements) robot = std::max(robot, m.robot_columns);
  const auto H_robot = stacked.H_robot().leftCols(robot);
  multiply_transposed(state.marginal<kRobot>(0).leftCols(robot), H_robot, stacked.PHt().topRows(kRobot));
  multiply_transposed(state.storage_P.block(kRobot, 0, rest, robot), H_robot, stacked.PHt().bottomRows(rest));
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    auto columns = stacked.PHt().middleCols(stacked.first_row[i], measurements[i].rows);
    add_landmark_part(state, measurements[i], columns);
    add_bias_part(state, measurements[i], columns);
  }
  multiply(H_robot, stacked.PHt().topRows(robot), stacked.S());
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const Measurement& m = measurements[i];
    const int count = static_cast<int>(m.H_landmark.cols());
    auto S_rows = stacked.S().middleRows(stacked.first_row[i], m.rows);
    if (count > 0) S_rows += m.H_landmark.lazyProduct(stacked.PHt().middleRows(m.landmark_at, count));
    if (m.bias_at >= 0) S_rows += m.bias_gain * stacked.PHt().middleRows(m.bias_at, m.rows);
    S_rows.middleCols(stacked.first_row[i], m.rows) += m.R;
  }
}

void scale_noise(StackedMeasurement& stacked, const std::vector<Measurement>& measurements, double ratio) {
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const Measurement& m = measurements[i];
    stacked.S().block(stacked.first_row[i], stacked.first_row[i], m.rows, m.rows) -=
        (1 - ratio * ratio) * m.R;
  }
}

void select_innovation(const StackedMeasurement& stacked, const std::vector<std::size_t>& indices,
                       StackedMeasurement& selected) {
  selected.first_row.assign(1, 0);
  for (const std::size_t i : indices)
    selected.first_row.push_back(selected.first_row.back() + stacked.first_row[i + 1] - stacked.first_row[i]);
  selected.resize(0, selected.first_row.back());
  for (std::size_t k = 0; k < indices.size(); ++k) {
    const int from = stacked.first_row[indices[k]], to = selected.first_row[k];
    const int rows = selected.first_row[k + 1] - to;
    selected.innovation().segment(to, rows) = stacked.innovation().segment(from, rows);
    for (std::size_t l = 0; l < indices.size(); ++l) {
      const int column = stacked.first_row[indices[l]], count = stacked.first_row[indices[l] + 1] - column;
      selected.S().block(to, selected.first_row[l], rows, count) =
          stacked.S().block(from, column, rows, count);
    }
  }
}

void select(const StackedMeasurement& stacked, const std::vector<std::size_t>& indices,
            StackedMeasurement& selected) {
  select_innovation(stacked, indices, selected);
  selected.resize(stacked.size, selected.rows);
  selected.blocks.clear();
  for (std::size_t k = 0; k < indices.size(); ++k) {
    for (const StackedMeasurement::Block& block : stacked.blocks)
      if (block.measurement == indices[k]) selected.blocks.push_back({k, block.at, block.H});
    const int from = stacked.first_row[indices[k]], to = selected.first_row[k];
    const int rows = selected.first_row[k + 1] - to;
    selected.H_robot().middleRows(to, rows) = stacked.H_robot().middleRows(from, rows);
    selected.sensitivity().middleRows(to, rows) = stacked.sensitivity().middleRows(from, rows);
    selected.PHt().middleCols(to, rows) = stacked.PHt().middleCols(from, rows);
  }
}

bool Whitening::compute(const StackedMeasurement& stacked) {
  rows_ = stacked.rows;
  reserve_workspace(storage_L_, rows_, rows_);
  if (rows_ > storage_innovation_.size()) storage_innovation_.resize(rows_ + kSpareRows);
  auto factor = storage_L_.topLeftCorner(rows_, rows_);
  factor = stacked.S();
  const bool positive = factorize(factor);
  auto whitened = storage_innovation_.head(rows_);
  whitened = stacked.innovation();
  L().triangularView<Eigen::Lower>().solveInPlace(whitened);
  return positive && stacked.innovation().allFinite();
}

void Whitening::solve(Eigen::Ref<Eigen::MatrixXd> B) const {
  L().triangularView<Eigen::Lower>().solveInPlace(B);
}

Nis Whitening::nis() const {
  return {innovation().squaredNorm(), rows_, 2 * L().diagonal().array().log().sum()};
}

}  // namespace slam
