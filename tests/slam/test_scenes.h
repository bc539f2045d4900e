// Shared by tests: images with known content, camera poses, and random states, covariances and measurements.
#pragma once

#include "slam/kalman.h"
#include "slam/vision/patch.h"
#include "tests/slam/synthetic_room.h"

namespace slam {

/// ∂f/∂x at x by central differences with the given step; f maps Eigen::VectorXd to Eigen::VectorXd.
template <typename Function>
Eigen::MatrixXd numerical_jacobian(const Function& f, const Eigen::VectorXd& x, double step = 1e-6) {
  Eigen::MatrixXd J;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    Eigen::VectorXd above = x, below = x;
    above(i) += step;
    below(i) -= step;
    const Eigen::VectorXd slope = (Eigen::VectorXd(f(above)) - Eigen::VectorXd(f(below))) / (2 * step);
    if (i == 0) J.resize(slope.size(), x.size());
    J.col(i) = slope;
  }
  return J;
}

/// Smooth noise from a known function, which can be drawn with sub-pixel shifts.
inline cv::Mat pattern(double dx, double dy) {
  cv::Mat image(120, 160, CV_8UC1);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) {
      const double x = u - dx, y = v - dy;
      image.ptr<uchar>(v)[u] = static_cast<uchar>(
          std::lround(127 + 40 * std::sin(0.31 * x + 0.17 * y) + 35 * std::sin(0.23 * y - 0.38 * x + 1) +
                      30 * std::cos(0.045 * x * std::sin(0.05 * y) + 0.41 * y)));
    }
  return image;
}

/// The mean of a robot at rest with a camera that looks along +x of W.
inline RobotVector looking_ahead(const Eigen::Vector3d& p_WC = {0, 0, 1.4}) {
  RobotVector x = RobotVector::Zero();
  x.segment<3>(kPosition) = p_WC;
  x.segment<4>(kOrientation) << 0.5, -0.5, 0.5, -0.5;
  return x;
}

inline Eigen::Isometry3d camera_pose(const RobotVector& x) {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.linear() = rotation_matrix(x.segment<4>(kOrientation));
  X_WC.translation() = x.segment<3>(kPosition);
  return X_WC;
}

/// A state in which no parameter is zero.
inline RobotVector generic_state() {
  RobotVector x = RobotVector::LinSpaced(-0.4, 0.9);
  x.segment<4>(kOrientation) = Eigen::Vector4d(0.9, 0.1, -0.2, 0.3).normalized();
  return x;
}

inline Eigen::Isometry3d pose(double angle, const Eigen::Vector3d& axis, const Eigen::Vector3d& at) {
  return Eigen::Translation3d(at) * Eigen::Isometry3d(Eigen::AngleAxisd(angle, axis.normalized()));
}

/// The camera of the EuRoC flying robot, and one behind a fisheye lens with the same field of view as the
/// default camera.
inline const RadialTangential kEurocLens{-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05};
inline const CameraIntrinsics kBrown{752, 480, 458.654, 457.296, 367.215, 248.375, kEurocLens};
inline const Equidistant kFisheyeLens{-0.0027, 0.0019, -0.0016, 0.0002};
inline const CameraIntrinsics kFisheye{512, 512, 191, 191, 255, 257, kFisheyeLens};

/// Blocks of `side` px in random grays: corners everywhere.
inline cv::Mat random_blocks(int columns, int side, std::uint64_t seed) {
  cv::Mat image(240, columns, CV_8UC1);
  std::mt19937_64 random(seed);
  for (int row = 0; row < image.rows; row += side)
    for (int column = 0; column < image.cols; column += side)
      image(cv::Rect(column, row, side, side) & cv::Rect(0, 0, image.cols, image.rows))
          .setTo(cv::Scalar(static_cast<double>(random() % 256)));
  return image;
}

inline Template template_at(const cv::Mat& image, const Eigen::Vector2i& pixel) {
  return warp(cut_patch(image, pixel), Eigen::Matrix2d::Identity()).value();
}

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

/// A robot and `landmarks` landmarks with 6 parameters each, all correlated.
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
  if (m.bias_at >= 0) H.middleCols<2>(m.bias_at) += m.bias_gain * Eigen::Matrix2d::Identity();
  return H;
}

/// Three measurements stacked densely: one of the robot, one of a landmark with a match bias, and another of
/// the robot. Two parameters of another landmark serve as the bias.
struct DenseStack {
  DenseStack(const State& state, Normal& normal)
      : measurements{random_measurement(3, 0, 0.1, normal), random_measurement(2, kRobot + 6, 0.3, normal),
                     random_measurement(1, 0, 0.2, normal)},
        H(6, state.size) {
    measurements[1].bias_at = kRobot, measurements[1].bias_gain = 1.4;
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
