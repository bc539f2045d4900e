#include "sim/score/trajectory.h"

#include <gtest/gtest.h>

#include "tests/sim/score/score_fixtures.h"

namespace sim::score {
namespace {

using std::numbers::pi;

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

TEST(Trajectory, LengthAndHeightRangeAreThoseOfThePositions) {
  const Trajectory bent{
      {Stamp(0), upright(0, 0, 0)}, {Stamp(1), upright(3, 4, 0)}, {Stamp(2), upright(3, 4, -12)}};
  EXPECT_EQ(path_length(bent), 17);
  EXPECT_EQ(height_range(bent), 12);
  EXPECT_EQ(path_length({at(0, 3)}), 0);
  EXPECT_EQ(path_length({}), 0);
  EXPECT_EQ(height_range({}), 0);
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
  const Eigen::Matrix3d R = scattered_pose(3, 5).linear();
  double best = 0, least = 1e9;
  for (double angle = -pi; angle < pi; angle += 1e-4)
    if (const double distance = (R - about_z(angle)).norm(); distance < least) least = distance, best = angle;
  EXPECT_NEAR(yaw(R), best, 1e-4);
}

TEST(Errors, AreDistancesAndAngles) {
  const std::vector<PosePair> pairs{{Stamp(0), upright(1, 2, 3, 0.5), upright(1, 2, 3, 0.5)},
                                    {Stamp(1), upright(1, 2, 3, 0.5), upright(4, 6, 15, 0.2)}};
  EXPECT_EQ(position_errors(pairs), (std::vector<double>{0, 13}));
  EXPECT_NEAR(orientation_errors(pairs)[0], 0, 1e-15);
  EXPECT_NEAR(orientation_errors(pairs)[1], 0.3, 1e-14);
}

TEST(Errors, YawErrorOfACameraIsAboutTheVerticalOfTheWorld) {
  const Eigen::Isometry3d estimate = looking(0.4);
  EXPECT_NEAR(yaw_error({Stamp(0), looking(0.3), estimate}), -0.1, 1e-15);
  Eigen::Isometry3d pitched = looking(0);
  pitched.linear() = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()).toRotationMatrix() * pitched.linear();
  EXPECT_NEAR(yaw_error({Stamp(0), pitched, looking(0)}), 0, 1e-15);
}

TEST(Errors, DriftIsTrueMinusPlannedInAxesOfTheStart) {
  const auto expect_drift = [](double start_yaw, double x, double y) {
    const Drift found =
        drift(upright(1.1, 0.2, 0.6, 0.3), upright(1, 0.5, 0.7, 0.1), upright(0, 0, 0.7, start_yaw));
    EXPECT_NEAR(found.x, x, 1e-15);
    EXPECT_NEAR(found.y, y, 1e-15);
    EXPECT_NEAR(found.yaw, 0.2, 1e-15);
  };
  expect_drift(0, 0.1, -0.3);
  expect_drift(pi / 2, -0.3, -0.1);  // facing y of W at the start: W (0.1, -0.3) is (-0.3, -0.1)
  EXPECT_NEAR(drift(upright(0, 0, 0, -3.1), upright(0, 0, 0, 3.1), upright(0, 0, 0)).yaw, 2 * pi - 6.2,
              1e-14);  // the short way
}

}  // namespace
}  // namespace sim::score
