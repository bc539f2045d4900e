// The self-check passes what is right and detects a lag of one sample.
#include "sim/live/self_check.h"

namespace {

using namespace sim;
using namespace std::chrono_literals;

std::chrono::milliseconds at(int i) { return std::chrono::milliseconds(5 * i); }

// Compares the readings of a body that turns back and forth with its truth `lag` readings earlier.
live::InertialCheck turning(int lag) {
  const auto yaw = [](int i) { return 0.3 * std::sin(0.02 * std::max(0, i)); };
  live::InertialCheck check(recording::TrueMotion{});
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d rate(0, 0, (yaw(i + 1) - yaw(i)) / 0.005), force(0, 0, walking::kGravity);
    const Eigen::AngleAxisd turned(yaw(i + 1 - lag), Eigen::Vector3d::UnitZ());
    check.add({at(i), at(i + 1), rate}, {at(i), at(i + 1), force}, {at(i + 1), Eigen::Isometry3d(turned)});
  }
  return check;
}

// The readings of a body that shakes and pitches at 30 Hz by 10 m/s² and 0.5 rad/s; the gyro's readings lag.
live::InertialCheck shaking(int lag) {
  constexpr double kRate = 2 * std::numbers::pi * 30;
  const auto pitch = [](double t) { return 0.5 / kRate * std::sin(kRate * t); };
  const auto motion = [&](double t) {
    recording::TrueMotion m;
    m.X_WG.linear() = Eigen::AngleAxisd(pitch(t), Eigen::Vector3d::UnitY()).toRotationMatrix();
    m.X_WG.translation().x() = -10 / (kRate * kRate) * std::sin(kRate * t + 0.8);
    m.v_WG.x() = -10 / kRate * std::cos(kRate * t + 0.8);
    return m;
  };
  const auto force = [&](double t) -> Eigen::Vector3d {
    return motion(t).X_WG.linear().transpose() *
           Eigen::Vector3d(10 * std::sin(kRate * t + 0.8), 0, walking::kGravity);
  };
  live::InertialCheck check(motion(0));
  for (int i = 0; i < 2000; ++i) {
    Eigen::Vector3d mean(0, 0, 0);
    for (int k = 0; k < 50; ++k) mean += force(0.005 * i + 1e-4 * (k + 0.5)) / 50;
    const double rate = (pitch(0.005 * (i + 1 - lag)) - pitch(0.005 * (i - lag))) / 0.005;
    recording::TrueMotion end = motion(0.005 * (i + 1));
    end.t = at(i + 1);
    check.add({at(i), at(i + 1), {0, rate, 0}}, {at(i), at(i + 1), mean}, end);
  }
  return check;
}

TEST(SelfCheck, NamesReadingsThatLagByOneSample) {
  EXPECT_EQ(turning(0).complaint(), std::nullopt);
  EXPECT_THAT(
      turning(1).complaint().value_or(""),
      testing::HasSubstr("integrated over 2.0 s, deviate from the true heading by 0.3438 deg, more than"));
}

TEST(SelfCheck, AllowsForTheStepLengthOfAVibratingRobotAndStillNamesALag) {
  EXPECT_GT(shaking(0).position_m.worst, 2 * live::kInertialPosition_m);
  EXPECT_EQ(shaking(0).complaint(), std::nullopt);
  EXPECT_THAT(shaking(1).complaint().value_or(""), testing::HasSubstr("deviate from the true path by"));
}

TEST(SelfCheck, ReadingsAreCheckedAgainAfterABlow) {
  live::InertialCheck check(
      recording::TrueMotion{at(0), Eigen::Isometry3d::Identity(), Eigen::Vector3d::Zero()});
  const auto add = [&](int i, const Eigen::Vector3d& force) {  // while it truly stands still
    check.add({at(i), at(i + 1), Eigen::Vector3d::Zero()}, {at(i), at(i + 1), force},
              {at(i + 1), Eigen::Isometry3d::Identity(), Eigen::Vector3d::Zero()});
  };
  const Eigen::Vector3d rest(0, 0, 9.81);
  add(0, rest + Eigen::Vector3d(1000, 0, 0));
  for (int i = 1; i < 200; ++i) add(i, rest);
  EXPECT_LT(check.position_m.worst, 1e-9);
  for (int i = 200; i < 400; ++i) add(i, rest + Eigen::Vector3d(0.1, 0, 0));
  EXPECT_GT(check.position_m.worst, live::kInertialPosition_m + check.position_m.by_step);
}

}  // namespace
