#include "slam/vision/landmark.h"

#include <gtest/gtest.h>

#include "slam/camera.h"
#include "tests/numerical_jacobian.h"

namespace slam {
namespace {

using tests::numerical_jacobian;

constexpr double kCentral = 1e-7;  // rounding 1e-16 / step 1e-6 of values up to 10, with room

const Eigen::Vector3d kFrom(0.5, -0.2, 1.3);
const Eigen::Vector4d kTurned(0.5, -0.4, 0.6, -0.45);  // not quite unit: the derivatives hold off the sphere

Parameters parameters(const LandmarkKind& kind, double rho = 0.25) {
  const bool point = std::holds_alternative<Point>(kind);
  Parameters y(point ? 3 : 6);
  if (point)
    y << 4, 0.7, 1.9;
  else
    y << 0.4, -0.3, 1.4, 0.2, 0.1, rho;
  return y;
}

const std::vector<LandmarkKind> kKinds{Point{}, InverseDepth{}};

TEST(Landmark, DirectionsJacobiansAreDerivativesForBothKinds) {
  for (const LandmarkKind& kind : kKinds) {
    const Parameters y = parameters(kind);
    const Direction d = direction(kind, y, kFrom, kTurned);
    const auto of = [&](const Parameters& at, const Eigen::Vector3d& r, const Eigen::Vector4d& q) {
      return Eigen::VectorXd(direction(kind, at, r, q).h_C);
    };
    EXPECT_LT((d.J_r - numerical_jacobian([&](const auto& r) { return of(y, r, kTurned); }, kFrom)).norm(),
              kCentral);
    EXPECT_LT((d.J_q - numerical_jacobian([&](const auto& q) { return of(y, kFrom, q); }, kTurned)).norm(),
              kCentral);
    EXPECT_LT((d.J_y - numerical_jacobian([&](const auto& at) { return of(at, kFrom, kTurned); }, y)).norm(),
              kCentral);
  }
}

TEST(Landmark, ThePixelOfAnInverseDepthIsThatOfItsPoint) {
  const Camera camera{CameraIntrinsics{}};
  const Eigen::Vector4d ahead(0.5, -0.5, 0.5, -0.5);  // looks along +x
  const Parameters y = parameters(InverseDepth{});
  Parameters p(3);
  p << position(InverseDepth{}, y);
  const auto a = camera.project(direction(InverseDepth{}, y, kFrom, ahead).h_C);
  const auto b = camera.project(direction(Point{}, p, kFrom, ahead).h_C);
  ASSERT_TRUE(a && b);
  EXPECT_LT((a->pixel - b->pixel).norm(), 1e-11);
}

TEST(Landmark, APointAtInfinityIsSeenAlongItsBearingFromAnywhere) {
  const Parameters y = parameters(InverseDepth{}, 0);
  const Eigen::Vector4d q = kTurned.normalized();
  const Eigen::Vector3d expected = rotation_matrix(q).transpose() * bearing(0.2, 0.1);
  for (const Eigen::Vector3d& r : {kFrom, Eigen::Vector3d(-7, 9, 1)}) {
    const Direction d = direction(InverseDepth{}, y, r, q);
    EXPECT_LT((d.h_C - expected).norm(), 1e-15);
    EXPECT_EQ(d.J_r.norm(), 0);
    EXPECT_TRUE(d.J_y.allFinite() && d.J_q.allFinite());
  }
}

TEST(Landmark, PositionsJacobiansAreDerivativesForBothKinds) {
  for (const LandmarkKind& kind : kKinds) {
    const auto numeric = numerical_jacobian(
        [&](const Eigen::VectorXd& y) { return Eigen::VectorXd(position(kind, y)); }, parameters(kind));
    EXPECT_LT((position_jacobian(kind, parameters(kind)) - numeric).norm(), kCentral);
  }
}

TEST(Landmark, TakesAsManyParametersAsItsKind) {
  Landmark landmark;
  EXPECT_EQ(landmark.size(), 6);
  landmark.kind = Point{};
  EXPECT_EQ(landmark.size(), 3);
}

}  // namespace
}  // namespace slam
