// Landmarks begun as a line with depth particles: the line's Jacobian, the particles' algebra, and a search
// that finds the depth.
#include "slam/depth_particles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <random>

#include "slam/landmark.h"
#include "slam/line_search.h"
#include "tests/numerical_jacobian.h"

namespace slam {
namespace {

using tests::numerical_jacobian;

constexpr double kCentral = 1e-7;  // of central differences with steps of 1e-6 and values of order 1

RobotVector looking_about() {
  RobotVector x = RobotVector::Zero();
  x.segment<3>(kPosition) << 0.3, -0.2, 1.4;
  x.segment<4>(kOrientation) << 0.52, -0.47, 0.49, -0.5;
  x.segment<4>(kOrientation).normalize();
  return x;
}

double sum(const std::vector<DepthParticle>& particles) {
  double sum = 0;
  for (const DepthParticle& p : particles) sum += p.probability;
  return sum;
}

TEST(DepthParticles, TheFlatPriorHasMeanAndDeviationOfTheUniformDistribution) {
  Options::Depth::Particles options;
  options.count = 1000;
  const DepthBelief flat = belief(flat_prior(options));
  EXPECT_NEAR(flat.mean_m, (0.5 + 12) / 2, 1e-9);
  EXPECT_NEAR(flat.sigma_m, (12 - 0.5) / std::sqrt(12.0), 1e-5);  // 1000 steps: relative 1/(2·1000²)
}

TEST(DepthParticles, ReweighingIsBayesRuleAndDropsWhatIsNegligible) {
  std::vector<DepthParticle> particles{{1, 0.25}, {2, 0.25}, {3, 0.25}, {4, 0.25}};
  reweigh(particles, {0.9, 0.3, 0.0, 0.001});
  ASSERT_EQ(particles.size(), 2U);  // 0.001/1.201 is below 0.05/3
  EXPECT_NEAR(particles[0].probability, 0.75, 1e-12);
  EXPECT_NEAR(belief(particles).mean_m, 1.25, 1e-12);
  EXPECT_NEAR(sum(particles), 1, 1e-12);
}

TEST(DepthParticles, NoParticleIsLeftWhereNoneIsFound) {
  std::vector<DepthParticle> particles{{1, 0.5}, {2, 0.5}};
  reweigh(particles, {0, 0});
  EXPECT_TRUE(particles.empty());
}

TEST(DepthParticles, TheLinesJacobianIsTheDerivativeOfItsBeginning) {
  const RobotVector x = looking_about();
  const Camera camera{CameraIntrinsics{}};
  const Ray ray = *camera.unproject({70, 180});
  const Beginning line = begin_line(x, ray, 1);
  const auto by_robot = [&](const Eigen::VectorXd& at) {
    return Eigen::VectorXd(begin_line(RobotVector(at), ray, 1).y);
  };
  EXPECT_LT((line.J_robot - numerical_jacobian(by_robot, x)).norm(), kCentral);
  const auto by_pixel = [&](const Eigen::VectorXd& pixel) {
    return Eigen::VectorXd(begin_line(x, *camera.unproject(Eigen::Vector2d(pixel)), 1).y);
  };
  const Eigen::MatrixXd J = numerical_jacobian(by_pixel, Eigen::Vector2d(70, 180));
  EXPECT_LT((line.noise - J * J.transpose()).norm(), kCentral);
  EXPECT_NEAR(line.y.tail<3>().norm(), 1, 1e-12);
}

TEST(DepthParticles, ALineIsSeenWhereThePointAtItsMeanDepthIs) {
  const RobotVector x = looking_about();
  const Camera camera{CameraIntrinsics{}};
  const Parameters y = begin_line(x, *camera.unproject({70, 180}), 1).y;
  const SemiInfiniteLine line{{{2, 0.5}, {4, 0.5}}};
  const Eigen::Vector3d r(0.5, 0.1, 1.35);
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  Parameters p(3);
  p << position(line, y);
  EXPECT_LT((direction(line, y, r, q).h_C - direction(Point{}, p, r, q).h_C).norm(), 1e-12);
  const auto h = [&](const Eigen::VectorXd& at) {
    return Eigen::VectorXd(direction(line, Parameters(at), r, q).h_C);
  };
  EXPECT_LT((direction(line, y, r, q).J_y - numerical_jacobian(h, y)).norm(), kCentral);
  const auto where = [&](const Eigen::VectorXd& at) {
    return Eigen::VectorXd(position(line, Parameters(at)));
  };
  EXPECT_LT((position_jacobian(line, y) - numerical_jacobian(where, y)).norm(), kCentral);
}

/// Blocks of noise, smoothed, wide enough to cut a shifted image out of.
cv::Mat pattern() {
  cv::Mat wide(240, 420, CV_8UC1);
  std::mt19937_64 random(5);
  for (int row = 0; row < wide.rows; row += 6)
    for (int column = 0; column < wide.cols; column += 6)
      wide(cv::Rect(column, row, 6, 6)).setTo(cv::Scalar(static_cast<double>(random() % 256)));
  return wide;
}

TEST(LineSearch, SidewaysMotionFindsTheDepthOfAFarWallAndNeverANearOne) {
  // A wall at 5 m facing a pinhole of 200 px that moves sideways: the picture shifts by 40 px a metre.
  constexpr double kWall_m = 5, kFocal_px = 200;
  CameraIntrinsics intrinsics;
  intrinsics.lens = OneParameterRadial{};
  intrinsics.fu_px = intrinsics.fv_px = kFocal_px;
  const Camera camera(intrinsics);
  const cv::Mat wide = pattern();
  RobotVector x = RobotVector::Zero();
  x.segment<4>(kOrientation) << 0.5, -0.5, 0.5, -0.5;  // z ahead along +x, right along −y
  Options options;
  options.depth.first_sight = FirstSight::particles;
  Landmark landmark;
  landmark.kind = SemiInfiniteLine{flat_prior(options.depth.particles)};
  landmark.patch = cut_patch(wide(cv::Rect(0, 0, 320, 240)), {200, 120});
  landmark.at = kRobot;
  const Beginning line = begin_line(x, *camera.unproject({200, 120}), 1);
  for (const int shift_px : {4, 8, 12, 16, 20}) {
    RobotVector moved = x;
    moved(kPosition + 1) = -shift_px * kWall_m / kFocal_px;
    Kalman kalman(moved, 1e-6 * RobotMatrix::Identity(), false);
    Beginning still = line;
    still.J_robot.setZero();
    kalman.append(still);
    landmark.X_WC_first = kalman.state().X_WC();
    landmark.X_WC_first.translation().setZero();
    search_along(wide(cv::Rect(shift_px, 0, 320, 240)), kalman, camera, options, landmark);
  }
  const auto& found = std::get<SemiInfiniteLine>(landmark.kind);
  ASSERT_FALSE(found.particles.empty());
  EXPECT_EQ(found.attempts, 5);
  const DepthBelief depth = belief(found.particles);
  EXPECT_LT(std::abs(depth.mean_m - kWall_m), 2 * depth.sigma_m);
  EXPECT_LT(depth.sigma_m, 0.3 * depth.mean_m);
  EXPECT_TRUE(converged(found, options.depth.particles));
  EXPECT_GT(found.particles.front().depth_m, 2.5);
}

}  // namespace
}  // namespace slam
