#include "slam/gyro.h"

#include <gtest/gtest.h>

#include <cmath>

#include "slam/rotation.h"
#include "tests/numerical_jacobian.h"

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

TEST(Gyro, ConstantRateIsItsOwnMean) {
  const auto rate = mean_rate(readings(milliseconds(0), milliseconds(30), kRateVector), milliseconds(0),
                              milliseconds(30), kSame, Options());
  ASSERT_TRUE(rate);
  EXPECT_LT((rate->w_C - kRateVector).norm(), 1e-13);  // a logarithm over 0.03 s
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

TEST(Gyro, AveragingReducesTheNoiseByTheRootOfTheNumberOfReadings) {
  const auto rate = mean_rate(readings(milliseconds(0), milliseconds(45), kRateVector), milliseconds(0),
                              milliseconds(45), kSame, Options());
  EXPECT_NEAR(rate->sigma_rad_s, 0.01 / 3, 1e-12);
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

TEST(Gyro, MeasurementsJacobianIsItsDerivative) {
  RobotVector x = RobotVector::LinSpaced(0.1, 2.2);
  const MeanRate rate{kRateVector, 0.02};
  const Eigen::MatrixXd numeric = -tests::numerical_jacobian(
      [&](const Eigen::VectorXd& at) -> Eigen::VectorXd { return measure_rate(at, rate).innovation; }, x);
  const Measurement m = measure_rate(x, rate);
  EXPECT_LT((m.H_robot - numeric).norm(), 1e-8);  // rounding 1e-16 / step 1e-6, with room
  EXPECT_EQ(m.R, 0.0004 * Eigen::Matrix3d::Identity());
}

TEST(Gyro, InnovationIsTheReadingWithoutRateAndBias) {
  RobotVector x = RobotVector::Zero();
  x.segment<3>(kRate) << 0.1, 0.2, 0.3;
  x.segment<3>(kGyroBias) << 0.01, 0.02, 0.03;
  const Measurement m = measure_rate(x, {Eigen::Vector3d(1, 1, 1), 0.01});
  EXPECT_LT((Eigen::Vector3d(m.innovation) - Eigen::Vector3d(0.89, 0.78, 0.67)).norm(), 1e-15);
}

TEST(Gyro, ACameraAtRestMeasuresARateOfZero) {
  RobotVector x = RobotVector::Zero();
  x.segment<3>(kRate) << 0.1, 0.2, 0.3;
  const Eigen::MatrixXd numeric = -tests::numerical_jacobian(
      [&](const Eigen::VectorXd& at) -> Eigen::VectorXd { return measure_rest(at, 0.02).innovation; }, x);
  const Measurement m = measure_rest(x, 0.02);
  EXPECT_EQ(Eigen::Vector3d(m.innovation), Eigen::Vector3d(-0.1, -0.2, -0.3));
  EXPECT_LT((m.H_robot - numeric).norm(), 1e-8);
  EXPECT_EQ(m.R, 0.0004 * Eigen::Matrix3d::Identity());
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

}  // namespace
}  // namespace slam
