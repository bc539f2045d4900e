// Random states, covariances and measurements for tests of the filter's algebra.
#pragma once

#include "slam/kalman.h"
#include "tests/slam/synthetic_room.h"

namespace slam {

using synthetic::Normal;

inline Eigen::MatrixXd random_matrix(int rows, int columns, Normal& normal) {
  Eigen::MatrixXd A(rows, columns);
  for (Eigen::Index i = 0; i < A.size(); ++i) A(i) = normal();
  return A;
}

inline RobotVector random_mean(Normal& normal) {
  RobotVector x = random_matrix(kRobot, 1, normal);
  x.segment<4>(kOrientation).normalize();
  return x;
}

inline RobotMatrix random_covariance(Normal& normal) {
  const RobotMatrix A = random_matrix(kRobot, kRobot, normal), P = 0.01 * A * A.transpose();
  return (P + P.transpose()) / 2;  // symmetric to the last bit
}

inline LandmarkInitialization random_landmark(Normal& normal) {
  const Eigen::MatrixXd A = random_matrix(6, 6, normal);
  return {random_matrix(6, 1, normal), random_matrix(6, kRobot, normal), 0.01 * A * A.transpose()};
}

/// A robot and `landmarks` landmarks of 6 parameters, all correlated.
inline Kalman random_filter(int landmarks, bool constrained, Normal& normal) {
  const RobotVector x = random_mean(normal);
  Kalman kalman({x, random_covariance(normal)}, constrained);
  for (int i = 0; i < landmarks; ++i) kalman.append(random_landmark(normal));
  return kalman;
}

inline Measurement random_measurement(int rows, int landmark_at, double sigma, Normal& normal) {
  Measurement m(rows);
  m.innovation = 0.1 * random_matrix(rows, 1, normal);
  m.H_robot = random_matrix(rows, kRobot, normal);
  if (landmark_at > 0) m.H_landmark = random_matrix(rows, 6, normal);
  m.landmark_at = landmark_at;
  m.R.diagonal().setConstant(sigma * sigma);
  return m;
}

inline Eigen::MatrixXd dense_H(const Measurement& m, int size) {
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(m.rows, size);
  H.leftCols<kRobot>() = m.H_robot;
  if (m.H_landmark.cols() > 0) H.middleCols(m.landmark_at, m.H_landmark.cols()) += m.H_landmark;
  return H;
}

/// Three measurements stacked densely: of the robot, of a landmark and of the robot again.
struct DenseStack {
  DenseStack(const State& state, Normal& normal)
      : measurements{random_measurement(3, 0, 0.1, normal), random_measurement(2, kRobot + 6, 0.3, normal),
                     random_measurement(1, 0, 0.2, normal)},
        H(6, state.size) {
    for (int row = 0; const Measurement& m : measurements) {
      H.middleRows(row, m.rows) = dense_H(m, state.size);
      R.block(row, row, m.rows, m.rows) = m.R;
      nu.segment(row, m.rows) = m.innovation;
      row += m.rows;
    }
    PHt = state.P() * H.transpose();
    S = H * PHt + R;
  }
  std::vector<Measurement> measurements;
  Eigen::MatrixXd H, PHt, S, R = Eigen::MatrixXd::Zero(6, 6);
  Eigen::VectorXd nu = Eigen::VectorXd::Zero(6);
};

}  // namespace slam
