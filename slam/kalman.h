// The extended Kalman filter's algebra: the only writer of the state's mean and covariance.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slam/state.h"

namespace slam {

/// A linearised measurement of at most 3 rows: z − h(x), ∂h/∂(robot), ∂h/∂(one landmark), noise.
struct Measurement {
  template <int Rows, int Columns>
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, Rows, Columns>;

  explicit Measurement(int row_count) : rows(row_count) {
    innovation.setZero(rows);
    H_robot.setZero(rows, kRobot);
    R.setZero(rows, rows);
  }

  int rows;
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> innovation;
  Small<3, kRobot> H_robot;
  int landmark_at = 0;     ///< where the landmark's parameters begin in the state; unused without H_landmark
  Small<3, 6> H_landmark;  ///< no columns where the measurement sees the robot alone
  Small<3, 3> R;
};

/// Makes a work space of at least that many rows and columns, with room for more when it grows; what it held
/// is lost.
void make_room(Eigen::MatrixXd& storage, int rows, int columns);

/// Several measurements of one instant, stacked: ν, PHᵀ and S = HPHᵀ + R. Storage grows ahead of need.
struct Joint {
  int size = 0, rows = 0;  ///< of the state, of the measurements
  Eigen::VectorXd storage_innovation;
  Eigen::MatrixXd storage_H_robot, storage_PHt, storage_S;
  std::vector<int> first_row;  ///< of each measurement, and the end

  auto innovation() { return storage_innovation.head(rows); }
  auto innovation() const { return storage_innovation.head(rows); }
  auto H_robot() { return storage_H_robot.topLeftCorner(rows, kRobot); }
  auto PHt() { return storage_PHt.topLeftCorner(size, rows); }
  auto PHt() const { return storage_PHt.topLeftCorner(size, rows); }
  auto S() { return storage_S.topLeftCorner(rows, rows); }
  auto S() const { return storage_S.topLeftCorner(rows, rows); }
  void resize(int state_size, int row_count);
};

/// Where the next landmark's parameters come from: y = g(robot, z), ∂y/∂robot, and the noise's share J R Jᵀ.
struct Beginning {
  Eigen::Matrix<double, 6, 1> y;
  Eigen::Matrix<double, 6, kRobot> J_robot;
  Eigen::Matrix<double, 6, 6> noise;
};

class Kalman {
 public:
  Kalman(const RobotVector& x, const RobotMatrix& P, bool observability_constrained);

  const State& state() const { return state_; }

  /// x ← f, P ← FPFᵀ + Q on the robot's part, and its correlations.
  void predict(const RobotVector& f, const RobotMatrix& F, const RobotMatrix& Q);

  /// Takes out of H what would seem to measure the heading of the whole world, which nothing can
  /// (Hesch et al. 2013: H' = H − HN(NᵀN)⁻¹Nᵀ); does nothing when the constraint is off.
  void constrain(Measurement& measurement) const;

  /// S = HPHᵀ + R of one measurement.
  Measurement::Small<3, 3> innovation_covariance(const Measurement& measurement) const;
  /// νᵀS⁻¹ν of one measurement; infinite where S is not positive definite.
  double nis(const Measurement& measurement) const;
  /// ln |S| of one measurement; not a number where S is not positive definite.
  double log_determinant(const Measurement& measurement) const;

  /// Fills joint for all the measurements together.
  void stack(const std::vector<Measurement>& measurements, Joint& joint) const;
  /// Joint update with all of it, P ← P − WWᵀ, W = PHᵀL⁻ᵀ, S = LLᵀ; then q is normalised. False, and nothing
  /// changes, where S is not positive definite.
  bool update(const Joint& joint);

  /// Adds a landmark's parameters at the end of the state; returns where they begin.
  int append(const Beginning& beginning);
  /// Replaces `before` parameters at `at` by the y.size() given, with y = g(parameters) and J =
  /// ∂g/∂parameters.
  void replace(int at, int before, const Eigen::Ref<const Eigen::VectorXd>& y,
               const Eigen::Ref<const Eigen::MatrixXd>& J);
  /// Makes three parameters at `at` less certain by Q.
  void blur(int at, const Eigen::Matrix3d& Q);
  /// Adds a point known to within sigma_m, whatever the robot believes; returns where it begins.
  int append_known(const Eigen::Vector3d& p_W, double sigma_m);
  /// Takes `count` parameters out of the state.
  void erase(int at, int count);

  /// Puts the robot at x with covariance P, independent of all landmarks.
  void restart(const RobotVector& x, const RobotMatrix& P);

  /// Everything finite, no negative variance, and the first `count` parameters' covariance positive
  /// semidefinite (scaled to unit variances, to 1e-9).
  bool sound(int count);

 private:
  void reserve(int size);
  void add_landmark_part(const Measurement& measurement, Eigen::Ref<Eigen::MatrixXd> PHt) const;
  void normalise_orientation();

  State state_;
  bool observability_constrained_;
  Eigen::MatrixXd W_, L_, robot_columns_, scaled_;  // work space
  Eigen::VectorXd white_;
};

}  // namespace slam
