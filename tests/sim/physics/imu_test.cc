#include "sim/physics/imu.h"

#include <gtest/gtest.h>

#include "walking/plan.h"

namespace sim::physics {
namespace {

using namespace std::chrono_literals;
const Eigen::Vector3d kDown(0, 0, -walking::kGravity);

ImuState tilted() {
  ImuState state;
  state.R_WG =
      (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitY()))
          .toRotationMatrix();
  state.v_WG = Eigen::Vector3d(0.4, -0.1, 0.05);
  return state;
}

TEST(Imu, AtRestMeasuresGravityUpwardsAndNoTurn) {
  ImuState from, to;
  to.t = walking::kTick;
  const ImuReading reading = reading_between(from, to, kDown);
  EXPECT_EQ(reading.gyro, Eigen::Vector3d::Zero());
  EXPECT_EQ(reading.specific_force, -kDown);
}

TEST(Imu, IntegratingAReadingLeadsFromOneStateToTheNext) {
  const ImuState from = tilted();
  ImuState to = from;
  to.t = walking::kTick;
  to.R_WG = from.R_WG * Eigen::AngleAxisd(0.004, Eigen::Vector3d(1, 2, -2) / 3.0).toRotationMatrix();
  to.v_WG += Eigen::Vector3d(0.01, 0.02, -0.015);
  const ImuReading reading = reading_between(from, to, kDown);
  const double dt = walking::kPeriod;
  const Eigen::Vector3d turn = reading.gyro * dt;
  const Eigen::Matrix3d R = from.R_WG * Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  const Eigen::Matrix3d R_amid =
      from.R_WG * Eigen::AngleAxisd(turn.norm() / 2, turn.normalized()).toRotationMatrix();
  const Eigen::Vector3d v = from.v_WG + dt * (R_amid * reading.specific_force + kDown);
  EXPECT_LT((R - to.R_WG).norm(), 1e-12);  // rounding of one Log and one Exp
  EXPECT_LT((v - to.v_WG).norm(), 1e-14);
}

// A sensor at rest on a turning table: the mean of gravity along its axes as they turn is gravity
// along the axes in the middle of the interval, but for (angle/2)²/6 of it.
TEST(Imu, MeasuresTheMeanOfAForceAlongItsAxesAsTheyTurn) {
  const ImuState from = tilted();
  ImuState to = from;
  to.t = walking::kTick;
  const double angle = 0.02;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  constexpr int n = 1000;
  for (int i = 0; i < n; ++i) {
    to.R_WG =
        from.R_WG * Eigen::AngleAxisd(angle * (i + 0.5) / n, Eigen::Vector3d::UnitX()).toRotationMatrix();
    sum -= to.R_WG.transpose() * kDown;
  }
  to.R_WG = from.R_WG * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const Eigen::Vector3d force = reading_between(from, to, kDown).specific_force;
  EXPECT_LT((force - sum / n).norm(), walking::kGravity * angle * angle / 24 + 1e-6);
  EXPECT_GT((from.R_WG.transpose() * -kDown - sum / n).norm(),
            0.05);  // along the axes at the beginning it is not
}

TEST(Imu, GivesNothingOverAnEmptyInterval) {
  const ImuReading reading = reading_between(tilted(), tilted(), kDown);
  EXPECT_EQ(reading.begin, reading.end);
  EXPECT_EQ(reading.gyro, Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace sim::physics
