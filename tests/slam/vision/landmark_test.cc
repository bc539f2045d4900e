#include "slam/vision/landmark.h"

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

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

TEST(Landmark, EveryKindIsSeenInTheDirectionOfItsPosition) {
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

TEST(InverseDepth, StartsOnTheRayAtTheDepthOfTheOptions) {
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

TEST(InverseDepth, LinearityIndexMatchesCivera) {
  const Vector6d y = by_inverse_depth(0.25);
  // from its anchor: d₁ = 4 m, cos α = 1, so L = 4 (σ/ρ²)/d₁ = 4 σ/ρ
  EXPECT_NEAR(linearity_index(y, 0.01, y.head<3>()), 4 * 0.01 / 0.25, 1e-13);
  // from 3 m to the side of the line of sight: d₁ = 5 m, cos α = 4/5
  const Eigen::Vector3d side = kBearing.cross(Eigen::Vector3d::UnitZ()).normalized();
  EXPECT_NEAR(linearity_index(y, 0.01, y.head<3>() + 3 * side), 4 * 0.01 / (0.25 * 0.25) * 0.8 / 5, 1e-13);
}

TEST(DepthParticles, TheUniformPriorHasTheMeanAndDeviationOfTheUniformDistribution) {
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

TEST(Patch, RefinesToAFewHundredthsOfAPixelAtAnyBrightnessAndContrast) {
  const Template t = template_at(pattern(0, 0), {70, 60});
  for (const double shift : {0.1, 0.35, 0.5, 0.8})
    for (const double contrast : {1.0, 0.5}) {
      cv::Mat image;
      pattern(shift, -shift / 2).convertTo(image, CV_8U, contrast, 20 * (1 - contrast));
      const auto match = refine(image, t, {70, 60});
      ASSERT_TRUE(match);
      EXPECT_NEAR(match->pixel.x(), 70 + shift, 0.05);  // gray values are whole numbers, samples bilinear
      EXPECT_NEAR(match->pixel.y(), 60 - shift / 2, 0.05);
      EXPECT_GT(match->correlation, 0.99);
    }
}

TEST(Patch, FlatPatchesGiveNoTemplateAndAreNotFound) {
  const cv::Mat flat(120, 160, CV_8UC1, cv::Scalar(90));
  const Eigen::Matrix2d I = Eigen::Matrix2d::Identity();
  EXPECT_FALSE(warp(cut_patch(flat, {70, 60}), I));
  EXPECT_FALSE(search_ellipse(flat, template_at(pattern(0, 0), {70, 60}), {70, 60}, I, 3));
}

TEST(Patch, ViewChangeIsTheDerivativeAcrossTheSurface) {
  const Camera camera(CameraIntrinsics{});
  const Eigen::Isometry3d first = Eigen::Isometry3d::Identity(),
                          now = pose(0.3, {0, 1, 0}, {-0.5, 0.1, 0.4}) * pose(0.05, {1, 0, 0}, {0, 0, 0});
  const Eigen::Vector3d p(0.6, -0.3, 3);
  const Eigen::Vector2d pixel = camera.project(now.inverse() * p)->pixel;
  const Eigen::Vector3d normal = surface_normal(first, p, {0.7, -0.4});
  const auto A = view_change(camera, first, now, p, normal, pixel);
  ASSERT_TRUE(A);
  const auto through =
      [&](const Eigen::Vector2d& u) -> Eigen::Vector2d {  // pixel now -> surface -> pixel first
    const Eigen::Vector3d line = now.linear() * camera.unproject(u)->h;
    const double s = normal.dot(p - now.translation()) / normal.dot(line);
    return camera.project(first.inverse() * (now.translation() + s * line))->pixel;
  };
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d e = 1e-4 * Eigen::Vector2d::Unit(i);
    EXPECT_NEAR((A->col(i) - (through(pixel + e) - through(pixel - e)) / 2e-4).norm(), 0, 1e-6);
  }
}

TEST(Patch, ASurfaceIsRotatedByTheAnglesOfItsTilt) {
  const Eigen::Isometry3d first = pose(0, {0, 0, 1}, {1, 2, 3});
  const double s = std::sin(0.5), c = std::cos(0.5), t = std::tan(0.5);
  for (const auto& [tilt, normal] : {std::pair<Eigen::Vector2d, Eigen::Vector3d>{{0, 0}, {0, 0, -1}},
                                     {{t, 0}, {s, 0, -c}},
                                     {{0, t}, {0, s, -c}}})
    EXPECT_LT((surface_normal(first, {1, 2, 7}, tilt) - normal).norm(), 1e-12) << tilt;
}

TEST(Patch, SurfacesSeenTooObliquelyAreNotMatched) {
  const Camera camera(CameraIntrinsics{});
  const Eigen::Isometry3d first = Eigen::Isometry3d::Identity(), now = pose(-1.4, {0, 1, 0}, {3, 0, 3.2});
  const Eigen::Vector3d p(0, 0, 3);
  const auto seen = camera.project(now.inverse() * p);
  ASSERT_TRUE(seen);
  EXPECT_FALSE(view_change(camera, first, now, p, surface_normal(first, p, {0, 0}), seen->pixel));
}

TEST(EllipseSearch, FindsTheSameAsOpenCvSearchingEveryPixel) {
  const cv::Mat first = pattern(0, 0), now = pattern(3, -2);
  const Eigen::Vector2i at(70, 60);
  const Eigen::Vector2d center(71.3, 59.6);
  Eigen::Matrix2d S;
  S << 4, 1.5, 1.5, 3;
  const auto found = search_ellipse(now, template_at(first, at), center, S, 3);
  ASSERT_TRUE(found);
  cv::Mat scores;
  cv::matchTemplate(now, first(cv::Rect(at.x() - 5, at.y() - 5, 11, 11)), scores, cv::TM_CCOEFF_NORMED);
  double best = -1;
  Eigen::Vector2i where(0, 0);
  for (int v = 20; v < 100; ++v)
    for (int u = 20; u < 140; ++u) {
      const Eigen::Vector2d nu = Eigen::Vector2d(u, v) - center;
      if (nu.dot(S.inverse() * nu) > 9) continue;
      const double c = scores.at<float>(v - 5, u - 5);
      if (c > best) best = c, where = {u, v};
    }
  EXPECT_EQ(found->pixel, where.cast<double>());
  EXPECT_NEAR(found->correlation, best, 1e-5);  // single precision
}

TEST(EllipseSearch, StaysInsideTheImageAtABoundedCost) {
  const cv::Mat image = pattern(0, 0);
  const Template t = template_at(image, {70, 60});
  EXPECT_TRUE(search_ellipse(image, t, {4, 4}, 1e6 * Eigen::Matrix2d::Identity(), 3));
  EXPECT_FALSE(search_ellipse(image, t, {-60, 60}, Eigen::Matrix2d::Identity(), 3));
}

}  // namespace
}  // namespace slam
