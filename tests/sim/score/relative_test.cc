#include "sim/score/relative.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sim/score/score_fixtures.h"

namespace sim::score {
namespace {

using Unit = Spans::Unit;
using Indices = std::vector<std::pair<std::size_t, std::size_t>>;
constexpr bool kAll = true;

// True poses at x = 0, 1, 2, ..., the estimate at twice that; one per 100 ms. The estimate turns by 10
// degrees about z from each pose to the next, the truth by half of that.
std::vector<PosePair> walked(int count) {
  std::vector<PosePair> pairs;
  for (int i = 0; i < count; ++i)
    pairs.push_back({std::chrono::milliseconds(100 * i), upright(i, 0, 0, 5 * i * kDegree),
                     upright(2 * i, 0, 0, 10 * i * kDegree)});
  return pairs;
}

Indices indices(int count, const Spans& which) {
  Indices all;
  for (const Span& span : spans(walked(count), which)) all.emplace_back(span.from, span.to);
  return all;
}

TEST(Relative, ConsecutiveSpansFollowOneAnother) {
  for (const Spans& each : {Spans{Unit::frames, 3},
                            {Unit::seconds, 0.3},
                            {Unit::seconds, 0.25},
                            {Unit::degrees, 29.9},
                            {Unit::radians, 0.52}})
    EXPECT_EQ(indices(8, each), (Indices{{0, 3}, {3, 6}}));
  EXPECT_EQ(indices(8, {Unit::meters, 4}), (Indices{{2, 4}, {4, 6}}));  // 4 m of the estimate
  EXPECT_EQ(indices(8, {Unit::meters, 2, !kAll, 0.1, true}), (Indices{{2, 4}, {4, 6}}));
  EXPECT_EQ(indices(9, {Unit::degrees, 19.9, !kAll, 0.1, true}), (Indices{{0, 4}, {4, 8}}));
}

TEST(Relative, AllSpansBeginAtEachPose) {
  for (const Spans& each : {Spans{Unit::frames, 3, kAll},
                            {Unit::seconds, 0.31, kAll},
                            {Unit::meters, 6, kAll},
                            {Unit::degrees, 30.5, kAll}})  // within 10 %
    EXPECT_EQ(indices(5, each), (Indices{{0, 3}, {1, 4}}));
  EXPECT_TRUE(indices(5, {Unit::seconds, 0.35, kAll}).empty());
  // 37 poses turn once around: 350 degrees are 10 degrees the other way.
  EXPECT_THAT(indices(37, {Unit::degrees, 10, kAll}),
              testing::Contains(std::pair<std::size_t, std::size_t>(0, 35)));
}

TEST(Relative, ATrajectoryThatIsTooShortOrStandsHasNoSpans) {
  for (const Unit unit : {Unit::frames, Unit::meters, Unit::seconds, Unit::radians})
    for (const bool all : {false, true})
      for (const int count : {0, 1, 2}) EXPECT_TRUE(indices(count, {unit, 100, all}).empty());
  std::vector<PosePair> standing = walked(50);
  for (PosePair& pair : standing) pair.X_true = pair.X_estimate = Eigen::Isometry3d::Identity();
  EXPECT_TRUE(spans(standing, {Unit::meters, 0.25}).empty());
  EXPECT_TRUE(spans(standing, {Unit::meters, 0.25, kAll}).empty());
  EXPECT_EQ(spans(standing, {Unit::seconds, 1}).size(), 4u);
}

TEST(Relative, TheDifferenceIsThatOfTheMotions) {
  const std::vector<PosePair> pairs{{Stamp(0), upright(0, 0, 0), upright(0, 0, 0)},
                                    {Stamp(1), upright(3, 0, 0), upright(6, 0, 0, 0.1)}};
  const Eigen::Isometry3d E = relative_difference(pairs, {0, 1});
  EXPECT_EQ(E.translation(), Eigen::Vector3d(3, 0, 0));  // 6 m instead of 3
  EXPECT_NEAR(rotation_vector(E.linear()).norm(), 0.1, 1e-15);
}

}  // namespace
}  // namespace sim::score
