// Linearized measurements, single and stacked: covariance and whitening of the innovation, and its NIS.
#pragma once

#include <cstddef>
#include <optional>

#include "slam/frame_report.h"

namespace slam {

/// A linearized measurement of at most 3 rows: the innovation z − h(x), the Jacobian ∂h/∂x with respect to
/// the robot and to at most one landmark, and the noise covariance R. sensitivity is the derivative of the
/// innovation with respect to the systematic errors, with the state held fixed.
struct Measurement {
  template <int Rows, int Columns>
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, Rows, Columns>;

  explicit Measurement(int row_count) : rows(row_count) {
    innovation.setZero(rows);
    sensitivity.setZero(rows, kSystematicErrors);
    H_robot.setZero(rows, kRobot);
    R.setZero(rows, rows);
  }

  int rows;
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> innovation;
  Eigen::Matrix<double, Eigen::Dynamic, kSystematicErrors, 0, 3, kSystematicErrors> sensitivity;
  Small<3, kRobot> H_robot;
  int robot_columns = kRobot;  ///< the later columns of H_robot are zero
  int landmark_at = 0;  ///< first index of the landmark's parameters in the state, if H_landmark has columns
  Small<3, 6> H_landmark;  ///< has no columns if the measurement depends only on the robot
  int bias_at = -1;        ///< first index of the match bias (MatchBiases); -1: none
  double bias_gain = 0;    ///< ∂h/∂bias is this times the unit matrix
  Small<3, 3> R;
};

/// S = H P Hᵀ + R.
Measurement::Small<3, 3> innovation_covariance(const State& state, const Measurement& measurement);

/// νᵀS⁻¹ν and ln |S|. If S is not positive definite, the former is infinite and the latter meaningless.
/// whitened: the whitened innovation of the last frame, replaced by this frame's.
Nis normalized_innovation_squared(const State& state, const Measurement& measurement,
                                  std::optional<Eigen::Vector3d>* whitened = nullptr);

/// C = A B and C = A Bᵀ, for matrices of more than a few rows; C must be neither A nor B. They are compiled
/// once, because each expression with a product instantiates Eigen's code again, which takes a second
/// to compile.
void multiply(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::MatrixXd>& B,
              Eigen::Ref<Eigen::MatrixXd> C);
void multiply_transposed(const Eigen::Ref<const Eigen::MatrixXd>& A,
                         const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Ref<Eigen::MatrixXd> C);
/// Replaces the lower triangle of A with its Cholesky factor. Returns false if A is not positive definite.
bool factorize(Eigen::Ref<Eigen::MatrixXd> A);

/// Enlarges a work space to at least the given numbers of rows and columns, with spare room, so that it
/// rarely grows. When it grows, its contents are lost.
void reserve_workspace(Eigen::MatrixXd& storage, int rows, int columns);

/// Stacked measurements: the innovation ν, its derivative with respect to the systematic errors (including
/// their effect through the state), H, PHᵀ and S = HPHᵀ + R. The storage is larger than needed, so that it
/// rarely grows.
struct StackedMeasurement {
  /// A part of H outside the robot's columns: the derivative of a measurement with respect to the parameters
  /// starting at `at`.
  struct Block {
    std::size_t measurement = 0;
    int at = 0;
    Measurement::Small<3, 6> H;
  };

  int size = 0, rows = 0;  ///< number of parameters in the state, number of rows of all the measurements
  Eigen::VectorXd storage_innovation;
  Sensitivity storage_sensitivity;
  Eigen::MatrixXd storage_H_robot, storage_PHt, storage_S;
  std::vector<Block> blocks;   ///< in the order of the measurements
  std::vector<int> first_row;  ///< first row of each measurement, and the number of rows at the end

  std::size_t count() const { return first_row.size() - 1; }
  auto innovation() { return storage_innovation.head(rows); }
  auto innovation() const { return storage_innovation.head(rows); }
  auto sensitivity() { return storage_sensitivity.topRows(rows); }
  auto sensitivity() const { return storage_sensitivity.topRows(rows); }
  auto H_robot() { return storage_H_robot.topLeftCorner(rows, kRobot); }
  auto H_robot() const { return storage_H_robot.topLeftCorner(rows, kRobot); }
  auto PHt() { return storage_PHt.topLeftCorner(size, rows); }
  auto PHt() const { return storage_PHt.topLeftCorner(size, rows); }
  auto S() { return storage_S.topLeftCorner(rows, rows); }
  auto S() const { return storage_S.topLeftCorner(rows, rows); }
  void resize(int state_size, int row_count);
};

/// Fills `stacked` from the measurements and the covariance of the state.
void stack(const State& state, const std::vector<Measurement>& measurements, StackedMeasurement& stacked);

/// Multiplies the noise standard deviation of each measurement in S by `ratio`. `measurements`: the stacked
/// measurements.
void scale_noise(StackedMeasurement& stacked, const std::vector<Measurement>& measurements, double ratio);

/// Fills `selected` with the measurements at the given indices, which must be in ascending order.
void select(const StackedMeasurement& stacked, const std::vector<std::size_t>& indices,
            StackedMeasurement& selected);
/// The same, but only the innovation and S.
void select_innovation(const StackedMeasurement& stacked, const std::vector<std::size_t>& indices,
                       StackedMeasurement& selected);

/// The Cholesky factor L of S = LLᵀ and the whitened innovation L⁻¹ν of stacked measurements.
class Whitening {
 public:
  /// Returns false if S is not positive definite or the innovation is not finite. The results are then
  /// meaningless.
  bool compute(const StackedMeasurement& stacked);
  /// The lower triangle is L; the rest is undefined.
  auto L() const { return storage_L_.topLeftCorner(rows_, rows_); }
  auto innovation() const { return storage_innovation_.head(rows_); }
  /// B ← L⁻¹B.
  void solve(Eigen::Ref<Eigen::MatrixXd> B) const;
  Nis nis() const;

 private:
  int rows_ = 0;
  Eigen::MatrixXd storage_L_;
  Eigen::VectorXd storage_innovation_;
};

}  // namespace slam
