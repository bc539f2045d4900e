#include "sim/score/trajectory.h"

#include <gmock/gmock.h>

#include "tests/sim/score/score_fixtures.h"

namespace sim::score {
namespace {

using std::numbers::pi, testing::HasSubstr;
using Unit = Spans::Unit;
using Indices = std::vector<std::pair<std::size_t, std::size_t>>;

const Eigen::Matrix3d kTurn =
    Eigen::AngleAxisd(0.9, Eigen::Vector3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix();

TimedPose at(std::int64_t t_ns, double x) { return {Stamp(t_ns), upright(x, 0, 0)}; }

TEST(Trajectory, StampsOfOneMomentArePairedAlsoIfTheyAreRounded) {
  const Trajectory truth{at(1'000'000, 1), at(2'000'000, 2), at(4'000'000, 4)};
  const auto pairs = pair_by_stamp(
      truth, {at(0, 0), at(2'000'001, 2.5), at(2'010'000, 9), at(3'000'000, 3), at(3'900'000, 5)});
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].t, Stamp(2'000'001));
  EXPECT_EQ(pairs[0].X_true.translation().x(), 2);
  EXPECT_EQ(pairs[0].X_estimate.translation().x(), 2.5);
  EXPECT_EQ(pairs[1].X_true.translation().x(), 4);
  EXPECT_TRUE(pair_by_stamp(truth, {}).empty());
  EXPECT_TRUE(pair_by_stamp({}, truth).empty());
}

TEST(Trajectory, InterpolatesPositionLinearlyAndOrientationAlongTheShortestTurn) {
  const Trajectory trajectory{{Stamp(0), upright(0, 0, 0, 3.0)}, {Stamp(100), upright(1, 2, 4, -3.0)}};
  const auto X = interpolate(trajectory, Stamp(25));
  ASSERT_TRUE(X);
  EXPECT_TRUE(X->translation().isApprox(Eigen::Vector3d(0.25, 0.5, 1), 1e-15));
  EXPECT_NEAR(yaw(X->linear()), 3.0 + 0.25 * (2 * pi - 6), 1e-12);  // by way of pi, not of 0
  EXPECT_TRUE(interpolate(trajectory, Stamp(0))->isApprox(trajectory[0].X, 0));
  EXPECT_TRUE(interpolate(trajectory, Stamp(100))->isApprox(trajectory[1].X, 0));
  for (const int outside : {-1, 101}) EXPECT_FALSE(interpolate(trajectory, Stamp(outside)));
  EXPECT_FALSE(interpolate({}, Stamp(0)));
}

TEST(Trajectory, PairsByInterpolationWithinTheTruthsTimeAndAcrossNoLongGap) {
  const Trajectory truth{at(10, 1), at(20, 2), at(60, 6)},
      estimate{at(5, 7), at(15, 7), at(40, 7), at(60, 7), at(65, 7)};
  const auto pairs = pair_by_interpolation(truth, estimate, Stamp(10));
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].X_true.translation().x(), 1.5);
  EXPECT_EQ(pairs[1].t, Stamp(60)) << "a true pose needs no interpolation";
  EXPECT_EQ(pair_by_interpolation(truth, estimate, Stamp(40)).size(), 3u);
}

TEST(Trajectory, PairsByNearestUseEachPoseOnceWithTheNearestOfSeveral) {
  const Trajectory many{at(0, 0), at(100, 1), at(200, 2), at(300, 3)}, few{at(95, 7), at(101, 8), at(109, 9)};
  const auto pairs = pair_by_nearest(many, few, Stamp(10)), swapped = pair_by_nearest(few, many, Stamp(10));
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].X_true.translation().x(), 1);
  EXPECT_EQ(pairs[0].X_estimate.translation().x(), 8);
  ASSERT_EQ(swapped.size(), 1u);
  EXPECT_EQ(swapped[0].X_true.translation().x(), 8);
}

TEST(Trajectory, RotationVectorIsAngleTimesAxis) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 3).normalized();
  for (const double angle : {0.0, 1e-9, 1e-3, 1.0, 3.0, 3.14159})
    EXPECT_LT((rotation_vector(Eigen::AngleAxisd(angle, axis).toRotationMatrix()) - angle * axis).norm(),
              1e-13)  // rounding of R's entries
        << angle;
  EXPECT_NEAR(rotation_vector(about_z(-pi)).norm(), pi, 1e-12);
}

TEST(Trajectory, YawIsTheNearestTurnAboutTheVertical) {
  for (const double angle : {2.5, -2.5}) EXPECT_NEAR(yaw(about_z(angle)), angle, 1e-15);
  // By brute force, for a rotation that is not about z.
  double best = 0, least = 1e9;
  for (double angle = -pi; angle < pi; angle += 1e-4)
    if (const double distance = (kTurn - about_z(angle)).norm(); distance < least)
      least = distance, best = angle;
  EXPECT_NEAR(yaw(kTurn), best, 1e-4);
}

TEST(Errors, YawIsAboutTheVerticalOfTheWorldAndDriftInAxesOfTheStart) {
  const Eigen::Isometry3d estimate = looking(0.4);
  EXPECT_NEAR(yaw_error({Stamp(0), looking(0.3), estimate}), -0.1, 1e-15);
  Eigen::Isometry3d pitched = looking(0);
  pitched.linear() = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()).toRotationMatrix() * pitched.linear();
  EXPECT_NEAR(yaw_error({Stamp(0), pitched, looking(0)}), 0, 1e-15);
  const auto expect_drift = [](double start_yaw, double x, double y) {
    const Eigen::Vector3d found =
        drift(upright(1.1, 0.2, 0.6, 0.3), upright(1, 0.5, 0.7, 0.1), upright(0, 0, 0.7, start_yaw));
    EXPECT_LT((found - Eigen::Vector3d(x, y, 0.2)).cwiseAbs().maxCoeff(), 1e-15);
  };
  expect_drift(0, 0.1, -0.3);
  expect_drift(pi / 2, -0.3, -0.1);  // facing y of W at the start: W (0.1, -0.3) is (-0.3, -0.1)
  EXPECT_NEAR(drift(upright(0, 0, 0, -3.1), upright(0, 0, 0, 3.1), upright(0, 0, 0)).z(), 2 * pi - 6.2,
              1e-14);  // the short way
}

Similarity aligned(const std::vector<PosePair>& pairs, Alignment alignment) {
  return std::get<Similarity>(align(pairs, alignment));
}

std::string reason(const std::vector<PosePair>& pairs, Alignment alignment) {
  return std::get<Absent>(align(pairs, alignment)).reason;
}

double ate(const std::vector<PosePair>& pairs, Alignment alignment) {
  return root_mean_square(position_errors(transformed(aligned(pairs, alignment), pairs)));
}

TEST(Alignment, UndoesTheMotionItAllowsExactly) {
  const std::vector<PosePair> pairs = curve_pairs();
  const Eigen::Vector3d shift(1, 2, 3);
  for (const auto& [alignment, S] :
       std::vector<std::pair<Alignment, Similarity>>{{Alignment::yaw_position, {1, about_z(2), shift}},
                                                     {Alignment::origin, {1, kTurn, shift}},
                                                     {Alignment::se3, {1, kTurn, shift}},
                                                     {Alignment::sim3, {0.37, kTurn, shift}},
                                                     {Alignment::scale, {0.37}}}) {
    const std::vector<PosePair> moved = transformed(S, pairs);
    for (const PosePair& pair : transformed(aligned(moved, alignment), moved)) {
      EXPECT_LT((pair.X_true.translation() - pair.X_estimate.translation()).norm(), 1e-12);
      EXPECT_LT((pair.X_true.linear() - pair.X_estimate.linear()).norm(), 1e-12);
    }
  }
  std::vector<PosePair> mirrored = pairs;
  for (PosePair& pair : mirrored) pair.X_estimate.translation().x() *= -1;
  EXPECT_NEAR(aligned(mirrored, Alignment::se3).R.determinant(), 1, 1e-12) << "a mirror image is not a turn";
  EXPECT_GT(ate(mirrored, Alignment::se3), 0.1);
}

TEST(Alignment, DegenerateCasesHaveAReason) {
  std::vector<PosePair> point(10), line = point, vertical = point;
  for (int i = 0; i < 10; ++i) {
    const auto place = [i](std::vector<PosePair>& pairs, const Eigen::Vector3d& p) {
      PosePair& pair = pairs[static_cast<std::size_t>(i)];
      pair.X_true.translation() = pair.X_estimate.translation() = p;
    };
    place(point, {1, 2, 3});
    place(line, {1.0 * i, 2.0 * i, 0.5 * i});
    place(vertical, {1, 2, 1.0 * i});
  }
  using enum Alignment;
  for (const Alignment a : {none, origin, yaw_position, se3, sim3})
    EXPECT_THAT(reason({}, a), HasSubstr("no pose"));
  for (const Alignment a : {se3, sim3}) {
    EXPECT_THAT(reason(point, a), HasSubstr("coincide"));
    EXPECT_THAT(reason(line, a), HasSubstr("one line"));
  }
  EXPECT_THAT(reason({line[3]}, se3), HasSubstr("coincide"));
  for (const auto& pairs : {point, vertical})
    EXPECT_THAT(reason(pairs, yaw_position), HasSubstr("do not spread"));
  EXPECT_NEAR(ate(line, yaw_position), 0, 1e-12);  // a line is enough for a turn about z
  EXPECT_NEAR(ate({line[3]}, origin), 0, 1e-12);
}

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

}  // namespace
}  // namespace sim::score
