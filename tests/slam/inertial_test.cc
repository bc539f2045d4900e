#include "slam/inertial.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/slam/synthetic_room.h"

namespace slam {
namespace {

using std::chrono::milliseconds;

const Eigen::Vector3d kRateVector(0.3, -0.7, 1.1);
const Eigen::Matrix3d kSame = Eigen::Matrix3d::Identity();

/// Readings of 5 ms from `from` to `to`, each of the given value.
std::vector<InertialSample> readings(milliseconds from, milliseconds to, const Eigen::Vector3d& value) {
  std::vector<InertialSample> samples;
  for (milliseconds t = from; t < to; t += milliseconds(5))
    samples.push_back({t, t + milliseconds(5), value});
  return samples;
}

TEST(Gyro, ReadingsAboutDifferentAxesAreComposedInTheirOrder) {
  std::vector<InertialSample> samples = readings(milliseconds(0), milliseconds(20), {20, 0, 0});
  for (const auto& s : readings(milliseconds(20), milliseconds(40), {0, 30, 0})) samples.push_back(s);
  const auto rate = mean_rate(samples, milliseconds(0), milliseconds(40), kSame, Options());
  const Eigen::Vector4d turned = quaternion_product(quaternion_exp({0.4, 0, 0}), quaternion_exp({0, 0.6, 0}));
  EXPECT_LT((quaternion_exp(0.04 * rate->w_C) - turned).norm(), 1e-14);
  EXPECT_GT((rate->w_C - Eigen::Vector3d(10, 15, 0)).norm(), 1);  // what a plain average would say
}

TEST(Gyro, ReadingsOutsideTheIntervalAreLeftOutAndStraddlingOnesCut) {
  std::vector<InertialSample> samples = readings(milliseconds(0), milliseconds(10), {9, 9, 9});
  for (const auto& s : readings(milliseconds(10), milliseconds(50), kRateVector)) samples.push_back(s);
  samples.push_back({milliseconds(50), milliseconds(60), {9, 9, 9}});
  const auto rate = mean_rate(samples, milliseconds(13), milliseconds(46), kSame, Options());
  ASSERT_TRUE(rate);
  EXPECT_LT((rate->w_C - kRateVector).norm(), 1e-13);
  EXPECT_NEAR(rate->sigma_rad_s, 0.01 * std::sqrt(0.005 / 0.033), 1e-12);
}

TEST(Gyro, MeanRateIsInTheCamerasAxes) {
  const Eigen::Matrix3d R_CG = Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
  const auto rate = mean_rate(readings(milliseconds(0), milliseconds(30), kRateVector), milliseconds(0),
                              milliseconds(30), R_CG, Options());
  EXPECT_LT((rate->w_C - R_CG * kRateVector).norm(), 1e-13);
}

TEST(Gyro, GivesNothingWhereLessThanHalfTheIntervalIsCovered) {
  const auto of = [](milliseconds covered) {
    return mean_rate(readings(milliseconds(0), covered, kRateVector), milliseconds(0), milliseconds(40),
                     kSame, Options());
  };
  EXPECT_FALSE(mean_rate({}, milliseconds(0), milliseconds(40), kSame, Options()));
  EXPECT_FALSE(of(milliseconds(15)));
  EXPECT_TRUE(of(milliseconds(20)));
}

TEST(Gyro, AGapAddsWhatTheRateMayHaveChangedMeanwhile) {
  const auto full = mean_rate(readings(milliseconds(0), milliseconds(40), kRateVector), milliseconds(0),
                              milliseconds(40), kSame, Options());
  const auto half = mean_rate(readings(milliseconds(0), milliseconds(20), kRateVector), milliseconds(0),
                              milliseconds(40), kSame, Options());
  EXPECT_LT((half->w_C - kRateVector).norm(), 1e-13);  // still a rate, not one with zeros averaged in
  EXPECT_GT(half->sigma_rad_s, 5 * full->sigma_rad_s);
}

TEST(Gyro, InnovationIsTheReadingWithoutRateAndBias) {
  RobotVector x = RobotVector::Zero();
  x.segment<3>(kRate) << 0.1, 0.2, 0.3;
  x.segment<3>(kGyroBias) << 0.01, 0.02, 0.03;
  const Measurement m = measure_rate(x, {Eigen::Vector3d(1, 1, 1), 0.01});
  EXPECT_LT((Eigen::Vector3d(m.innovation) - Eigen::Vector3d(0.89, 0.78, 0.67)).norm(), 1e-15);
}

TEST(Gyro, TheLastReadingAloneIsTheRateAtTheFrame) {
  Options options;
  options.gyro.readings = GyroReadings::last;
  auto samples = readings(milliseconds(0), milliseconds(30), kRateVector);
  samples.back().value *= 2;
  const auto rate = mean_rate(samples, milliseconds(0), milliseconds(30), kSame, options);
  ASSERT_TRUE(rate);
  EXPECT_EQ(rate->w_C, Eigen::Vector3d(2 * kRateVector));
  EXPECT_EQ(rate->sigma_rad_s, options.gyro.sigma_rad_s);
  EXPECT_FALSE(mean_rate({}, milliseconds(0), milliseconds(30), kSame, options));
}

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
