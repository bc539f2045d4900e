#include "sim/score/surfaces.h"

#include <gtest/gtest.h>

#include <functional>
#include <map>

#include "tests/sim/score/score_fixtures.h"

namespace sim::score {
namespace {

using Kind = Surface::Kind;
using Eigen::Vector3d;

// By hand: shapes at the origin, rays along axes. The other shapes are compared with their definitions below.
TEST(Surfaces, HitsAreWhereGeometryHasThem) {
  const Vector3d x = Vector3d::UnitX(), z = Vector3d::UnitZ();
  const auto hit = [](Kind kind, const Vector3d& size, const Vector3d& origin, const Vector3d& direction) {
    return first_hit({{kind, Eigen::Isometry3d::Identity(), size}}, origin, direction);
  };
  EXPECT_EQ(hit(Kind::box, {1, 2, 3}, {-5, 0, 0}, x), 4);
  EXPECT_EQ(hit(Kind::box, {1, 2, 3}, {0, 0, 0}, x), 1);  // from inside: the wall ahead
  EXPECT_EQ(hit(Kind::box, {1, 2, 3}, {-5, 2.1, 0}, x), std::nullopt);
  EXPECT_EQ(hit(Kind::box, {1, 2, 3}, {5, 0, 0}, x), std::nullopt);  // behind
  EXPECT_EQ(hit(Kind::cylinder, {1, 2, 0}, {0.5, 0.5, 5}, -z), 3);
  EXPECT_NEAR(*hit(Kind::capsule, {1, 2, 0}, {-5, 0, 2.6}, x), 4.2, 1e-14);  // 0.6 up the cap: 0.8 wide
  EXPECT_EQ(hit(Kind::plane, {0, 0, 1}, {100, 100, 5}, -z), 5);
  EXPECT_EQ(hit(Kind::plane, {0, 0, 1}, {0, 0, -5}, z), std::nullopt);  // from below it is not seen
  EXPECT_EQ(hit(Kind::plane, {1, 2, 1}, {0.9, 1.9, 5}, -z), 5);
  EXPECT_EQ(hit(Kind::plane, {1, 2, 1}, {1.1, 0, 5}, -z), std::nullopt);
}

TEST(Surfaces, TheNearestIsHitOrNone) {
  const Surface near{Kind::box, upright(5, 0, 0), {1, 1, 1}}, far{Kind::box, upright(10, 0, 0), {1, 1, 1}};
  EXPECT_EQ(first_hit({far, near}, Vector3d::Zero(), Vector3d::UnitX()), 4);
  EXPECT_EQ(first_hit({far}, Vector3d::Zero(), Vector3d::UnitX()), 9);
  EXPECT_EQ(first_hit({far, near}, Vector3d::Zero(), Vector3d::UnitY()), std::nullopt);
}

// The shapes' definitions, independent of rays: below 0 inside the shape, above outside.
const std::map<Kind, std::function<double(const Vector3d&)>> kShapes{
    {Kind::box, [](const Vector3d& p) { return (p.cwiseAbs() - Vector3d(0.5, 0.3, 0.7)).maxCoeff(); }},
    {Kind::sphere, [](const Vector3d& p) { return p.norm() - 0.5; }},
    {Kind::cylinder,
     [](const Vector3d& p) { return std::max(p.head<2>().norm() - 0.5, std::abs(p.z()) - 0.3); }},
    {Kind::ellipsoid, [](const Vector3d& p) { return p.cwiseQuotient(Vector3d(0.5, 0.3, 0.7)).norm() - 1; }},
    {Kind::capsule,
     [](const Vector3d& p) { return (p - Vector3d(0, 0, std::clamp(p.z(), -0.3, 0.3))).norm() - 0.5; }},
    {Kind::plane, [](const Vector3d& p) { return p.z(); }}};

TEST(Surfaces, HitsAreTheFirstCrossingFoundByMarching) {
  int hits = 0, misses = 0;
  for (const auto& [kind, level] : kShapes)
    for (int i = 0; i < 100; ++i) {
      const Surface surface{kind, scattered_pose(i, 11),
                            kind == Kind::plane ? Vector3d(0, 0, 1) : Vector3d(0.5, 0.3, 0.7)};
      const Vector3d origin = 2 * scattered(i, 20),
                     direction = (surface.X_WS.translation() + scattered(i, 30) - origin).normalized();
      const auto level_at = [&, &level_ = level](double s) {
        return level_(surface.X_WS.inverse() * (origin + s * direction));
      };
      if (level_at(0) < 0) continue;
      double s = 0;
      while (s < 8 && level_at(s) > 0) s += 1e-3;
      const auto found = first_hit({surface}, origin, direction);
      EXPECT_NEAR(found && *found < 7.9 ? level_at(*found) : 0, 0,
                  1e-12);  // also if grazed between two steps
      if (s < 8 && level_at(s - 1e-3) > 1e-4) {
        ASSERT_TRUE(found);
        EXPECT_NEAR(*found, s, 1.1e-3);  // a step of the march
        ++hits;
      } else if (s >= 8) {
        EXPECT_TRUE(!found || *found > 7.9 || kind != Kind::plane);
        misses += !found;
      }
    }
  EXPECT_GT(hits, 100);
  EXPECT_GT(misses, 20);
}

}  // namespace
}  // namespace sim::score
