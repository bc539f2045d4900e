#include "sim/score/errors.h"

#include <gtest/gtest.h>

#include "tests/sim/score/random_trajectory.h"

namespace sim::score {
namespace {

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
  EXPECT_NEAR(yaw_error({Stamp(0), truth, estimate}), 0, 1e-15);  // a pitch is no yaw
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
