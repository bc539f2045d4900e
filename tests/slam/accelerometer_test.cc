#include "slam/accelerometer.h"

#include <gtest/gtest.h>

#include "slam/gyro.h"
#include "tests/slam/synthetic_room.h"

namespace slam {
namespace {

synthetic::Walk noise_free() {
  synthetic::Walk walk;
  walk.gyro_sigma_rad_s = walk.accelerometer_sigma_m_s2 = 0;
  return walk;
}

TEST(Accelerometer, IncrementIsTheChangeOfTheCamerasMeanVelocity) {
  const synthetic::Walk walk = noise_free();
  const synthetic::Recording recording(walk);
  for (int frame = 60; frame < 140; frame += 7) {
    const Observation o = recording.observation(frame), next = recording.observation(frame + 1);
    const InertialInterval earlier{walk.stamp(frame - 1), o.t, o.gyro, o.accelerometer};
    const InertialInterval later{o.t, next.t, next.gyro, next.accelerometer};
    const auto increment =
        velocity_increment(earlier, later, synthetic::calibration().X_CG, Eigen::Vector3d::Zero(), Options{});
    ASSERT_TRUE(increment);
    const Eigen::Isometry3d X0 = walk.X_WC(seconds(earlier.from)), X1 = walk.X_WC(seconds(o.t)),
                            X2 = walk.X_WC(seconds(next.t));
    const Eigen::Vector3d change = (X2.translation() - X1.translation()) / seconds(next.t - o.t) -
                                   (X1.translation() - X0.translation()) / seconds(o.t - earlier.from);
    const Eigen::Vector3d measured =
        X1.linear() * increment->increment_C + increment->duration_s * Eigen::Vector3d(0, 0, -9.81);
    EXPECT_NEAR((measured - change).norm(), 0,
                3e-5);  // m/s: acceleration taken as constant over 5 ms readings
  }
}

TEST(Accelerometer, GivesNothingWhenReadingsAreMissing) {
  const synthetic::Walk walk = noise_free();
  const synthetic::Recording recording(walk);
  const Observation o = recording.observation(10), next = recording.observation(11);
  const InertialInterval whole{walk.stamp(9), o.t, o.gyro, o.accelerometer};
  InertialInterval holed{o.t, next.t, next.gyro, next.accelerometer};
  const auto X_CG = synthetic::calibration().X_CG;
  EXPECT_TRUE(velocity_increment(whole, holed, X_CG, Eigen::Vector3d::Zero(), Options{}));
  holed.accelerometer.erase(holed.accelerometer.begin() + 2);
  EXPECT_FALSE(velocity_increment(whole, holed, X_CG, Eigen::Vector3d::Zero(), Options{}));
}

TEST(Gyro, TurnsTheCameraOfAWalkExactlyAsItTurned) {
  const synthetic::Recording recording(noise_free());
  const synthetic::Walk walk = noise_free();
  for (const int frame : {40, 100, 301}) {
    const Observation o = recording.observation(frame);
    const Stamp before = walk.stamp(frame - 1);
    const auto rate = mean_rate(o.gyro, before, o.t, synthetic::calibration().X_CG.linear(), Options{});
    ASSERT_TRUE(rate);
    const Eigen::Matrix3d turned =
        walk.X_WC(seconds(before)).linear().transpose() * walk.X_WC(seconds(o.t)).linear();
    const Eigen::Vector4d q = quaternion_exp(rate->w_C * seconds(o.t - before));
    EXPECT_NEAR((rotation_matrix(q) - turned).norm(), 0, 1e-12);
  }
}

}  // namespace
}  // namespace slam
