#include "slam/vision/landmark.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

const Eigen::Vector3d kFrom(0.5, -0.2, 1.3);
const Eigen::Vector4d kTurned = Eigen::Vector4d(0.5, -0.4, 0.6, -0.45).normalized();
const Eigen::Vector3d kBearing(std::cos(0.2) * std::cos(0.7), std::cos(0.2) * std::sin(0.7), -std::sin(0.2));

Vector6d by_inverse_depth(double rho) {
  Vector6d y;
  y << 0.4, -0.3, 1.4, 0.7, -0.2, rho;
  return y;
}

TEST(Landmark, IsSeenInTheDirectionOfItsPositionInAllKinds) {
  const LandmarkInitialization line =
      initialize_line(generic_state(), *Camera{CameraIntrinsics{}}.unproject({70, 180}), 1);
  for (const auto& [kind, y] : {std::pair<LandmarkKind, Parameters>{InverseDepth{}, by_inverse_depth(0.25)},
                                {SemiInfiniteLine{{{2, 0.5}, {4, 0.5}}}, line.y}}) {
    const Parameters p = position(kind, y);
    const Eigen::Vector3d a = direction(kind, y, kFrom, kTurned).h_C,
                          b = direction(Point{}, p, kFrom, kTurned).h_C;
    EXPECT_LT((a.normalized() - b.normalized()).norm(), 1e-12);
  }
}

TEST(InverseDepth, APointAtInfinityIsSeenAlongItsBearingFromAnywhere) {
  for (const Eigen::Vector3d& r : {kFrom, Eigen::Vector3d(-7, 9, 1)}) {
    const Direction d = direction(InverseDepth{}, by_inverse_depth(0), r, kTurned);
    EXPECT_LT((d.h_C - rotation_matrix(kTurned).transpose() * kBearing).norm(), 1e-15);
    EXPECT_EQ(d.J_r.norm(), 0);
    EXPECT_TRUE(d.J_y.allFinite() && d.J_q.allFinite());
  }
}

TEST(InverseDepth, IsInitializedOnTheRayAtTheDepthOfTheOptions) {
  const auto ray = Camera(CameraIntrinsics{}).unproject({50, 200});
  Options::Depth options;
  options.inverse_1_m = 0.2;
  const RobotVector x = generic_state();
  const Parameters y = initialize_inverse_depth(x, *ray, 1, Eigen::Vector2d::Zero(), options).y;
  const Eigen::Vector3d along = rotation_matrix(x.segment<4>(kOrientation)) * ray->h.normalized();
  EXPECT_LT((position(InverseDepth{}, y) - x.head<3>() - 5 * along).norm(), 1e-13);
}

TEST(InverseDepth, APointAtInfinityOrBehindItHasAFinitePositionAndIsNeverLinear) {
  for (const double rho : {0.0, -0.1}) {
    const Vector6d y = by_inverse_depth(rho);
    EXPECT_TRUE(position(InverseDepth{}, y).allFinite() && position_jacobian(InverseDepth{}, y).allFinite());
    EXPECT_EQ(linearity_index(y, 0.01, {0, 0, 1}), std::numeric_limits<double>::infinity());
  }
}

TEST(InverseDepth, LinearityIndexIsThatOfCivera) {
  const Vector6d y = by_inverse_depth(0.25);
  // from its anchor: d₁ = 4 m, cos α = 1, so L = 4 (σ/ρ²)/d₁ = 4 σ/ρ
  EXPECT_NEAR(linearity_index(y, 0.01, y.head<3>()), 4 * 0.01 / 0.25, 1e-13);
  // from 3 m to the side of the line of sight: d₁ = 5 m, cos α = 4/5
  const Eigen::Vector3d side = kBearing.cross(Eigen::Vector3d::UnitZ()).normalized();
  EXPECT_NEAR(linearity_index(y, 0.01, y.head<3>() + 3 * side), 4 * 0.01 / (0.25 * 0.25) * 0.8 / 5, 1e-13);
}

TEST(DepthParticles, TheUniformPriorHasMeanAndDeviationOfTheUniformDistribution) {
  Options::Depth::Particles options;
  options.count = 1000;
  const DepthMoments flat = depth_moments(uniform_prior(options));
  EXPECT_NEAR(flat.mean_m, (0.5 + 12) / 2, 1e-9);
  EXPECT_NEAR(flat.sigma_m, (12 - 0.5) / std::sqrt(12.0), 1e-5);  // 1000 steps: relative 1/(2·1000²)
}

TEST(DepthParticles, ReweightingIsBayesRuleAndDropsNegligibleParticles) {
  std::vector<DepthParticle> particles{{1, 0.25}, {2, 0.25}, {3, 0.25}, {4, 0.25}}, unlikely = particles;
  reweight(particles, {0.9, 0.3, 0.0, 0.001});
  ASSERT_EQ(particles.size(), 2U);  // 0.001/1.201 is below 0.05/3
  EXPECT_NEAR(particles[0].probability, 0.75, 1e-12);
  EXPECT_NEAR(particles[1].probability, 0.25, 1e-12);
  reweight(unlikely, {0, 0, 0, 0});
  EXPECT_TRUE(unlikely.empty());
}

}  // namespace
}  // namespace slam
