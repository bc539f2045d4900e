#include "sim/score/trajectory.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/sim/score/random_trajectory.h"

namespace sim::score {
namespace {

using std::numbers::pi;

TEST(Trajectory, StampsOfOneMomentArePairedAlsoIfTheyAreRounded) {
  const auto at = [](double ms, double x) {
    return TimedPose{Stamp(static_cast<std::int64_t>(1e6 * ms)), upright(x, 0, 0)};
  };
  const Trajectory truth{at(1, 1), at(2, 2), at(4, 4)};
  const auto pairs = pair_by_stamp(truth, {at(0, 0), at(2.000001, 2.5), at(2.01, 9), at(3, 3), at(3.9, 5)});
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
  EXPECT_FALSE(interpolate(trajectory, Stamp(-1)));
  EXPECT_FALSE(interpolate(trajectory, Stamp(101)));
  EXPECT_FALSE(interpolate({}, Stamp(0)));
}

TEST(Trajectory, PairsByInterpolationWithinTheTruthsTimeAndAcrossNoLongGap) {
  const Trajectory truth{
      {Stamp(10), upright(1, 0, 0)}, {Stamp(20), upright(2, 0, 0)}, {Stamp(60), upright(6, 0, 0)}};
  Trajectory estimate;
  for (const int t : {5, 15, 40, 60, 65}) estimate.push_back({Stamp(t), upright(7, 0, 0)});
  const auto pairs = pair_by_interpolation(truth, estimate, Stamp(10));
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].X_true.translation().x(), 1.5);
  EXPECT_EQ(pairs[1].t, Stamp(60)) << "a true pose needs no interpolation";
  EXPECT_EQ(pair_by_interpolation(truth, estimate, Stamp(40)).size(), 3u);
}

TEST(Trajectory, PairsByNearestUseEachPoseOnceWithTheNearestOfSeveral) {
  const Trajectory many{{Stamp(0), upright(0, 0, 0)},
                        {Stamp(100), upright(1, 0, 0)},
                        {Stamp(200), upright(2, 0, 0)},
                        {Stamp(300), upright(3, 0, 0)}};
  const Trajectory few{
      {Stamp(95), upright(7, 0, 0)}, {Stamp(101), upright(8, 0, 0)}, {Stamp(109), upright(9, 0, 0)}};
  const auto pairs = pair_by_nearest(many, few, Stamp(10)), swapped = pair_by_nearest(few, many, Stamp(10));
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].X_true.translation().x(), 1);
  EXPECT_EQ(pairs[0].X_estimate.translation().x(), 8);
  ASSERT_EQ(swapped.size(), 1u);
  EXPECT_EQ(swapped[0].X_true.translation().x(), 8);
}

TEST(Trajectory, PathLengthIsTheSumOfTheSteps) {
  EXPECT_EQ(path_length(
                {{Stamp(0), upright(0, 0, 0)}, {Stamp(1), upright(3, 4, 0)}, {Stamp(2), upright(3, 4, 12)}}),
            17);
  EXPECT_EQ(path_length({{Stamp(0), upright(3, 4, 5)}}), 0);
  EXPECT_EQ(path_length({}), 0);
}

TEST(Trajectory, RotationVectorIsAngleTimesAxis) {
  for (const double angle : {0.0, 1e-9, 1e-3, 1.0, 3.0, 3.14159}) {
    const Eigen::Vector3d v = angle * Eigen::Vector3d(1, -2, 3).normalized();
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(angle, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
    EXPECT_LT((rotation_vector(R) - v).norm(), 1e-13) << angle;  // rounding of R's entries
  }
  EXPECT_NEAR(rotation_vector(upright(0, 0, 0, -pi).linear()).norm(), pi, 1e-12);
}

TEST(Trajectory, YawIsTheNearestTurnAboutTheVertical) {
  EXPECT_NEAR(yaw(upright(0, 0, 0, 2.5).linear()), 2.5, 1e-15);
  EXPECT_NEAR(yaw(upright(0, 0, 0, -2.5).linear()), -2.5, 1e-15);
  // By brute force, for a rotation that is not about z.
  const Eigen::Matrix3d R = scattered_pose(3, 5).linear();
  double best = 0, least = 1e9;
  for (double angle = -pi; angle < pi; angle += 1e-4)
    if (const double distance = (R - upright(0, 0, 0, angle).linear()).norm(); distance < least)
      least = distance, best = angle;
  EXPECT_NEAR(yaw(R), best, 1e-4);
}

TEST(Errors, AreDistancesAndAngles) {
  const std::vector<PosePair> pairs{{Stamp(0), upright(1, 2, 3, 0.5), upright(1, 2, 3, 0.5)},
                                    {Stamp(1), upright(1, 2, 3, 0.5), upright(4, 6, 15, 0.2)}};
  EXPECT_EQ(position_errors(pairs), (std::vector<double>{0, 13}));
  EXPECT_NEAR(orientation_errors(pairs)[0], 0, 1e-15);
  EXPECT_NEAR(orientation_errors(pairs)[1], 0.3, 1e-14);
  EXPECT_NEAR(yaw_error(pairs[1]), 0.3, 1e-14);
}

TEST(Errors, YawErrorOfACameraIsAboutTheVerticalOfTheWorld) {
  // A camera that looks ahead: x right, y down, z forward.
  Eigen::Isometry3d estimate = Eigen::Isometry3d::Identity();
  estimate.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Eigen::Isometry3d truth = estimate;
  truth.linear() = Eigen::AngleAxisd(-0.1, Eigen::Vector3d::UnitZ()).toRotationMatrix() * estimate.linear();
  EXPECT_NEAR(yaw_error({Stamp(0), truth, estimate}), -0.1, 1e-15);
  truth.linear() = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()).toRotationMatrix() * estimate.linear();
  EXPECT_NEAR(yaw_error({Stamp(0), truth, estimate}), 0, 1e-15);  // a pitch is not a yaw
}

TEST(Errors, HeightRangeIsGreatestMinusLeast) {
  EXPECT_EQ(height_range({{Stamp(0), upright(0, 0, 1.5, 0)},
                          {Stamp(1), upright(9, 9, 1.25, 0)},
                          {Stamp(2), upright(0, 0, 1.375, 0)}}),
            0.25);
  EXPECT_EQ(height_range({}), 0);
}

TEST(Errors, DriftIsTrueMinusPlannedInAxesOfTheStart) {
  const Drift straight = drift(upright(1.1, 0.2, 0.6, 0.3), upright(1, 0.5, 0.7, 0.1), upright(0, 0, 0.7, 0));
  EXPECT_NEAR(straight.x, 0.1, 1e-15);
  EXPECT_NEAR(straight.y, -0.3, 1e-15);
  EXPECT_NEAR(straight.yaw, 0.2, 1e-15);
  const Drift turned =
      drift(upright(1.1, 0.2, 0.6, 0.3), upright(1, 0.5, 0.7, 0.1), upright(0, 0, 0.7, M_PI / 2));
  EXPECT_NEAR(turned.x, -0.3, 1e-15);  // facing y of W at the start: W (0.1, -0.3) is (-0.3, -0.1)
  EXPECT_NEAR(turned.y, -0.1, 1e-15);
  EXPECT_NEAR(turned.yaw, 0.2, 1e-15);
  EXPECT_NEAR(drift(upright(0, 0, 0, -3.1), upright(0, 0, 0, 3.1), upright(0, 0, 0, 0)).yaw, 2 * M_PI - 6.2,
              1e-14);  // the short way
}

}  // namespace
}  // namespace sim::score
