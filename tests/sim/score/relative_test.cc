#include "sim/score/relative.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "tests/sim/score/random_trajectory.h"

namespace sim::score {
namespace {

using Unit = Spans::Unit;
using Indices = std::vector<std::pair<std::size_t, std::size_t>>;

Indices indices(const std::vector<Span>& spans) {
  Indices all;
  for (const Span& span : spans) all.emplace_back(span.from, span.to);
  return all;
}

// True poses at x = 0, 1, 2, ...; the estimate at twice that; one per 100 ms.
std::vector<PosePair> straight(int count) {
  std::vector<PosePair> pairs(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    PosePair& pair = pairs[static_cast<std::size_t>(i)];
    pair.t = std::chrono::milliseconds(100 * i);
    pair.X_true.translation().x() = i;
    pair.X_estimate.translation().x() = 2 * i;
  }
  return pairs;
}

TEST(Relative, ConsecutiveSpansFollowOneAnother) {
  EXPECT_EQ(indices(spans(straight(8), {Unit::frames, 3})), (Indices{{0, 3}, {3, 6}}));
  EXPECT_EQ(indices(spans(straight(8), {Unit::seconds, 0.3})), (Indices{{0, 3}, {3, 6}}));
  EXPECT_EQ(indices(spans(straight(8), {Unit::seconds, 0.25})),
            (Indices{{0, 3}, {3, 6}}));  // at least that long
  EXPECT_EQ(indices(spans(straight(8), {Unit::meters, 4})),
            (Indices{{2, 4}, {4, 6}}));  // 4 m of the estimate
  Spans truth{Unit::meters, 2};
  truth.along_truth = true;
  EXPECT_EQ(indices(spans(straight(8), truth)), (Indices{{2, 4}, {4, 6}}));
}

TEST(Relative, AllSpansBeginAtEachPose) {
  EXPECT_EQ(indices(spans(straight(5), {Unit::frames, 3, true})), (Indices{{0, 3}, {1, 4}}));
  EXPECT_EQ(indices(spans(straight(5), {Unit::seconds, 0.31, true})),
            (Indices{{0, 3}, {1, 4}}));  // within 10 %
  EXPECT_TRUE(spans(straight(5), {Unit::seconds, 0.35, true}).empty());
  EXPECT_EQ(indices(spans(straight(5), {Unit::meters, 6, true})), (Indices{{0, 3}, {1, 4}}));
}

// A turn of 10 degrees about z from each pose to the next.
std::vector<PosePair> turning(int count) {
  std::vector<PosePair> pairs = straight(count);
  for (int i = 0; i < count; ++i) {
    PosePair& pair = pairs[static_cast<std::size_t>(i)];
    const double turned = i * 10 * std::numbers::pi / 180;
    pair.X_estimate.linear() = Eigen::AngleAxisd(turned, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    pair.X_true.linear() = Eigen::AngleAxisd(turned / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }
  return pairs;
}

TEST(Relative, TurningAddsUpInConsecutiveSpansAndIsDirectInAll) {
  EXPECT_EQ(indices(spans(turning(8), {Unit::degrees, 29.9})), (Indices{{0, 3}, {3, 6}}));
  EXPECT_EQ(indices(spans(turning(8), {Unit::radians, 0.52})), (Indices{{0, 3}, {3, 6}}));
  Spans truth{Unit::degrees, 19.9};
  truth.along_truth = true;
  EXPECT_EQ(indices(spans(turning(9), truth)), (Indices{{0, 4}, {4, 8}}));
  EXPECT_EQ(indices(spans(turning(5), {Unit::degrees, 30.5, true})), (Indices{{0, 3}, {1, 4}}));
  // 37 poses turn once around: 350 degrees are 10 degrees the other way.
  const auto around = indices(spans(turning(37), {Unit::degrees, 10, true}));
  EXPECT_NE(std::find(around.begin(), around.end(), std::pair<std::size_t, std::size_t>(0, 35)),
            around.end());
}

TEST(Relative, FootstepsEndAtEveryDeltaTh) {
  using std::chrono::milliseconds;
  Spans steps{Unit::footsteps, 2};
  steps.footsteps = {milliseconds(110), milliseconds(190), milliseconds(310), milliseconds(390),
                     milliseconds(520)};
  EXPECT_EQ(indices(spans(straight(7), steps)), (Indices{{1, 3}, {3, 5}}));
  steps.footsteps[1] = milliseconds(120);  // nearest to the same pose as the first
  EXPECT_EQ(indices(spans(straight(7), {Unit::footsteps, 1, true, 0.1, false, steps.footsteps})),
            (Indices{{1, 3}, {3, 4}, {4, 5}}));
  steps.footsteps[1] = milliseconds(190);
  steps.all = true;
  EXPECT_EQ(indices(spans(straight(7), steps)), (Indices{{1, 3}, {2, 4}, {3, 5}}));
}

TEST(Relative, TooShortATrajectoryHasNoSpans) {
  for (const Unit unit : {Unit::frames, Unit::meters, Unit::seconds, Unit::radians, Unit::footsteps})
    for (const bool all : {false, true})
      for (const int count : {0, 1, 2}) EXPECT_TRUE(spans(straight(count), {unit, 100, all}).empty());
}

TEST(Relative, StandingStillHasSpansOfTimeAndNoneOfMetres) {
  std::vector<PosePair> standing = straight(50);
  for (PosePair& pair : standing) pair.X_true = pair.X_estimate = Eigen::Isometry3d::Identity();
  EXPECT_TRUE(spans(standing, {Unit::meters, 0.25}).empty());
  EXPECT_TRUE(spans(standing, {Unit::meters, 0.25, true}).empty());
  EXPECT_EQ(spans(standing, {Unit::seconds, 1}).size(), 4u);
}

TEST(Relative, TheDifferenceIsThatOfTheMotions) {
  std::vector<PosePair> pairs = straight(4);
  pairs[3].X_estimate.linear() = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Isometry3d E = relative_difference(pairs, {0, 3});
  EXPECT_EQ(E.translation(), Eigen::Vector3d(3, 0, 0));  // 6 m instead of 3
  EXPECT_NEAR(rotation_vector(E.linear()).norm(), 0.1, 1e-15);
}

}  // namespace
}  // namespace sim::score
