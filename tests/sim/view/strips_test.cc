#include "sim/view/strips.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/view/shown_run.h"

namespace sim::view {
namespace {

using nlohmann::json;
using testing::ElementsAre;

// A force of 100 N at (0.02, 0.01) of a sole that is turned by a right angle and stands at (1, 2).
TEST(ZeroMomentPoint, IsWhereTheForceActs) {
  const SoleForce sole{{1, 2, M_PI / 2}, {0, 0, 100}, {1, -2, 0}}, other{{5, 5, 0}, {0, 0, 0}, {0, 0, 0}};
  const auto p = zero_moment_point({sole, other});
  ASSERT_TRUE(p.has_value());
  EXPECT_NEAR(p->x(), 1 - 0.01, 1e-12);
  EXPECT_NEAR(p->y(), 2 + 0.02, 1e-12);
}

TEST(ZeroMomentPoint, OfTwoSolesIsBetweenThemByTheirLoads) {
  const auto p = zero_moment_point(
      {SoleForce{{0, 0, 0}, {0, 0, 100}, {0, 0, 0}}, SoleForce{{0, 1, 0}, {0, 0, 300}, {0, 0, 0}}});
  EXPECT_NEAR(p->y(), 0.75, 1e-12);
  EXPECT_FALSE(zero_moment_point(
                   {SoleForce{{0, 0, 0}, {0, 0, 10}, {0, 0, 0}}, SoleForce{{0, 0, 0}, {0, 0, 5}, {0, 0, 0}}})
                   .has_value());
}

TEST(SupportPolygon, IsTheConvexHullAndTheMarginIsToItsNearestEdge) {
  const auto hull = convex_hull({{0, 0}, {2, 0}, {1, 0.5}, {2, 1}, {0, 1}, {1, 0}});
  EXPECT_THAT(hull, ElementsAre(Eigen::Vector2d(0, 0), Eigen::Vector2d(2, 0), Eigen::Vector2d(2, 1),
                                Eigen::Vector2d(0, 1)));
  EXPECT_NEAR(margin_inside(hull, {0.5, 0.2}), 0.2, 1e-12);
  EXPECT_NEAR(margin_inside(hull, {2.5, 0.5}), -0.5, 1e-12);
}

// The left foot is set down, slips by 3 mm, and is lifted; the right one never carries load.
TEST(Strips, SlipIsMeasuredFromWhereAFootWasSetDown) {
  Strips strips;
  std::optional<Eigen::Vector3d> landed;
  for (const auto& [load, x] : {std::pair{500.0, 1.0}, {400.0, 1.003}, {30.0, 1.003}, {5.0, 1.1}}) {
    Frame frame{.t = std::chrono::milliseconds(33 * strips.figures()[4].lines[0].x.size())};
    frame.feet.emplace();
    (*frame.feet)[0] = {.truth = {x, 0, 0}, .load_n = load};
    strips.add(frame);
    landed = (*frame.feet)[0].landed;
    EXPECT_EQ(frame.support.size(), load > 20 ? 4u : 0u);
  }
  EXPECT_FALSE(landed.has_value());
  const auto& slip = strips.figures()[4].lines[0].y;
  ASSERT_EQ(slip.size(), 4u);
  EXPECT_EQ(slip[0], 0);
  EXPECT_NEAR(slip[2], 3, 1e-9);
  EXPECT_TRUE(std::isnan(slip[3]));
  EXPECT_THAT(strips_html(strips.figures()), testing::HasSubstr("data-figure='slip'"));
}

TEST(ModelBytes, NumbersAreAlignedBehindTheirList) {
  Model model;
  model.pieces.push_back({-1, 0, {0, 1, 2}, {0, 0, 1}, {1, 0, 0}, {0.5f, 0.25f}, {0, 0, 0}});
  const std::string bytes = model_bytes(model);
  const auto length = static_cast<std::size_t>(static_cast<unsigned char>(bytes[0]));
  EXPECT_EQ(length % 4, 0u);
  EXPECT_EQ(json::parse(bytes.substr(4, length)),
            json::parse(R"([{"body":-1,"picture":0,"vertices":1,"indices":3}])"));
  EXPECT_EQ(bytes.size(), 4 + length + 4 * (3 + 3 + 3 + 2 + 3));
  float u = 0;
  std::memcpy(&u, bytes.data() + 4 + length + 4 * 9, 4);
  EXPECT_EQ(u, 0.5f);
}

}  // namespace
}  // namespace sim::view
