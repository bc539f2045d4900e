#include "slam/vision/landmark.h"

#include <gtest/gtest.h>

#include <cmath>

#include "slam/vision/landmark.h"
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

TEST(DepthParticles, TheUniformPriorHasMeanAndDeviationOfTheUniformDistribution) {
  Options::Depth::Particles options;
  options.count = 1000;
  const DepthMoments flat = depth_moments(uniform_prior(options));
  EXPECT_NEAR(flat.mean_m, (0.5 + 12) / 2, 1e-9);
  EXPECT_NEAR(flat.sigma_m, (12 - 0.5) / std::sqrt(12.0), 1e-5);  // 1000 steps: relative 1/(2·1000²)
}

TEST(DepthParticles, ReweighingIsBayesRuleAndDropsWhatIsNegligible) {
  std::vector<DepthParticle> particles{{1, 0.25}, {2, 0.25}, {3, 0.25}, {4, 0.25}};
  reweight(particles, {0.9, 0.3, 0.0, 0.001});
  ASSERT_EQ(particles.size(), 2U);  // 0.001/1.201 is below 0.05/3
  EXPECT_NEAR(particles[0].probability, 0.75, 1e-12);
  EXPECT_NEAR(depth_moments(particles).mean_m, 1.25, 1e-12);
  EXPECT_NEAR(sum(particles), 1, 1e-12);
}

TEST(DepthParticles, NoParticleIsLeftWhereAllLikelihoodsAreZero) {
  std::vector<DepthParticle> particles{{1, 0.5}, {2, 0.5}};
  reweight(particles, {0, 0});
  EXPECT_TRUE(particles.empty());
}

TEST(DepthParticles, TheLinesJacobianIsTheDerivativeOfItsInitialization) {
  const RobotVector x = looking_about();
  const Camera camera{CameraIntrinsics{}};
  const Ray ray = *camera.unproject({70, 180});
  const LandmarkInitialization line = initialize_line(x, ray, 1);
  const auto by_robot = [&](const Eigen::VectorXd& at) {
    return Eigen::VectorXd(initialize_line(RobotVector(at), ray, 1).y);
  };
  EXPECT_LT((line.J_robot - numerical_jacobian(by_robot, x)).norm(), kCentral);
  const auto by_pixel = [&](const Eigen::VectorXd& pixel) {
    return Eigen::VectorXd(initialize_line(x, *camera.unproject(Eigen::Vector2d(pixel)), 1).y);
  };
  const Eigen::MatrixXd J = numerical_jacobian(by_pixel, Eigen::Vector2d(70, 180));
  EXPECT_LT((line.noise - J * J.transpose()).norm(), kCentral);
  EXPECT_NEAR(line.y.tail<3>().norm(), 1, 1e-12);
}

TEST(DepthParticles, ALineIsSeenWhereThePointAtItsMeanDepthIs) {
  const RobotVector x = looking_about();
  const Camera camera{CameraIntrinsics{}};
  const Parameters y = initialize_line(x, *camera.unproject({70, 180}), 1).y;
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

TEST(DepthParticles, ALineConvergesByItsRelativeDepthErrorAndFailsByParticlesOrAttempts) {
  Options::Depth::Particles options;
  options.fewest = 2;
  options.attempts = 3;
  const SemiInfiniteLine sharp{{{3.9, 0.5}, {4.1, 0.5}}}, blurred{{{2, 0.5}, {6, 0.5}}};
  EXPECT_TRUE(converged(sharp, options));
  EXPECT_FALSE(converged(blurred, options));
  EXPECT_FALSE(has_failed({sharp.particles, 3}, options));
  EXPECT_TRUE(has_failed({sharp.particles, 4}, options));
  EXPECT_TRUE(has_failed({{{4, 1}}, 0}, options));
}

}  // namespace
}  // namespace slam
