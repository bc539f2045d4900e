#include "walking/stabilizer.h"

#include "tests/walking/walks.h"

namespace walking {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

const double kWeight = kRobot.mass * kGravity;
const Vector3d kUp = Vector3d::UnitZ(), kStill = Vector3d::Zero();

double angle_between(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

TEST(Attitude, FollowsATurnUsingTheGyro) {
  Attitude attitude(kUp);
  const Vector3d rate(0.6, -0.3, 0.8);
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (int k = 0; k < 100; ++k) {
    R = R * Eigen::AngleAxisd(rate.norm() * kPeriod, rate.normalized());
    attitude.update(rate, R.transpose() * (kGravity * kUp), kStill, kPeriod);
  }
  // The correction uses the vertical one tick ahead of the gyro's: 4e-3 rad, times gain 0.15/s, over 0.5 s.
  EXPECT_LT(angle_between(attitude.up(), R.transpose() * kUp), 5e-4);
  EXPECT_GT(angle_between(attitude.up(), kUp), 0.2);
}

TEST(Attitude, FindsTheVerticalAtTheRateOfItsGain) {
  const AttitudeOptions options{.bias_gain_per_s2 = 0};
  const double wrong = 0.05;
  Attitude attitude(Vector3d(std::sin(wrong), 0, std::cos(wrong)), options);
  const int ticks = static_cast<int>(1 / options.accelerometer_gain_per_s / kPeriod);
  for (int k = 0; k < ticks; ++k) attitude.update(kStill, kGravity * kUp, kStill, kPeriod);
  // The sine of the error decays: at 0.05 rad, it is within 1e-3 of an exponential.
  EXPECT_NEAR(angle_between(attitude.up(), kUp), wrong * std::exp(-1), 1e-3 * wrong);
}

TEST(Attitude, LearnsAConstantBiasOfTheGyroButNotAboutTheVertical) {
  Attitude attitude(kUp);
  const Vector3d bias(0.01, -0.005, 0.02);
  for (int k = 0; k < 60000; ++k) attitude.update(bias, kGravity * kUp, kStill, kPeriod);  // 300 s
  EXPECT_LT((attitude.bias() - Vector3d(bias.x(), bias.y(), 0)).norm(), 1e-4);
  EXPECT_LT(angle_between(attitude.up(), kUp), 1e-3);
}

TEST(Attitude, IsNotTiltedByAnAccelerationItIsGiven) {
  Attitude with_motion(kUp), without_motion(kUp);
  const Vector3d acceleration(1.0, 0.5, 0);
  for (int k = 0; k < 200; ++k) {
    with_motion.update(kStill, kGravity * kUp + acceleration, acceleration, kPeriod);
    without_motion.update(kStill, kGravity * kUp + acceleration, kStill, kPeriod);
  }
  EXPECT_LT(angle_between(with_motion.up(), kUp), 1e-12);
  EXPECT_GT(angle_between(without_motion.up(), kUp), 0.01);
}

Reference on_the_left_foot() {
  Reference reference = standing();
  const Vector3d shift(0, 0.095, 0);
  reference.com += shift;
  reference.zmp += shift.head<2>();
  reference.X_PB.translation() += shift;
  reference.X_PR.translation().z() = 0.05;
  reference.support = Support::left;
  return reference;
}

/// Readings of a robot at rest that moves exactly as planned, with the left foot carrying the fraction `left`
/// of its weight.
SensorReadings as_planned(const Reference& reference, double left) {
  SensorReadings readings;
  readings.accelerometer = Vector3d(0, 0, kGravity);
  readings.q = inverse_kinematics(kRobot, reference, kRobot.posture).q;
  const double ahead = reference.zmp.x() - kRobot.sole_ahead;
  readings.left.force.z() = left * kWeight;
  readings.right.force.z() = (1 - left) * kWeight;
  readings.left.torque.y() = -ahead * readings.left.force.z();
  readings.right.torque.y() = -ahead * readings.right.force.z();
  return readings;
}

/// Readings of a standing robot that turns by these angles within the tick.
SensorReadings turning(double roll, double pitch) {
  SensorReadings readings = as_planned(standing(), 0.5);
  readings.gyro << roll / kPeriod, pitch / kPeriod, 0;
  return readings;
}

/// All blocks switched off except the estimators and the distribution of the load.
StabilizerOptions estimators_alone() {
  StabilizerOptions options;
  options.tracking.enabled = options.ankle_admittance.enabled = options.force_difference.enabled =
      options.leg_compliance.enabled = options.body_attitude.enabled = false;
  return options;
}

/// The same, plus one block.
template <class Block>
StabilizerOptions with(Block StabilizerOptions::*block) {
  StabilizerOptions options = estimators_alone();
  (options.*block).enabled = true;
  return options;
}

Posture after(Stabilizer& stabilizer, const Reference& reference, const SensorReadings& readings, int ticks) {
  Posture posture;
  for (int k = 0; k < ticks; ++k) posture = stabilizer.step(reference, readings);
  return posture;
}

double distance(const Posture& a, const Posture& b) {
  return (a.X_PB.matrix() - b.X_PB.matrix()).norm() + (a.X_PL.matrix() - b.X_PL.matrix()).norm() +
         (a.X_PR.matrix() - b.X_PR.matrix()).norm();
}

double roll_of(const Eigen::Isometry3d& X) { return std::atan2(X.linear()(2, 1), X.linear()(2, 2)); }
double pitch_of(const Eigen::Isometry3d& X) { return std::asin(-X.linear()(2, 0)); }

TEST(Stabilizer, LeavesThePlanAloneIfAllReadingsAreAsPlannedOrIfSwitchedOff) {
  StabilizerOptions options;
  options.leg_compliance.enabled = false;  // this block acts on the planned load alone
  for (const auto& [reference, left] : {std::pair{standing(), 0.5}, std::pair{on_the_left_foot(), 1.0}}) {
    Stabilizer stabilizer(kRobot, options);
    const Posture posture = after(stabilizer, reference, as_planned(reference, left), 200);
    EXPECT_LT(distance(posture, reference), 1e-9);
    EXPECT_LT(stabilizer.state().com_error.norm(), 1e-12);
  }
  options.enabled = false;
  Stabilizer off(kRobot, options);
  EXPECT_EQ(distance(after(off, standing(), SensorReadings{}, 10), standing()), 0);
}

TEST(Stabilizer, EstimatesATiltAndTheShiftedCenterOfMassUnlessAttitudeIsOff) {
  StabilizerOptions options = estimators_alone();
  for (const double pitch : {0.02, 0.0}) {
    options.attitude.enabled = pitch != 0;
    Stabilizer stabilizer(kRobot, options);
    stabilizer.step(standing(), turning(0, 0.02));
    EXPECT_NEAR(stabilizer.state().tilt.y(), pitch, 1e-5);  // the accelerometer pulls back 0.15/s · 5 ms
    // The whole body turns about the ankles.
    const double height = standing().com.z() - 0.105;
    EXPECT_NEAR(stabilizer.state().com_error.x(), pitch * height, 1e-4);  // second order of the tilt
    EXPECT_NEAR(stabilizer.state().com_error.y(), 0, 1e-9);
  }
}

TEST(Stabilizer, PutsTheDesiredZmpFurtherOutThanTheCenterOfMass) {
  Stabilizer stabilizer(kRobot, with(&StabilizerOptions::tracking));
  stabilizer.step(standing(), turning(0, 0.02));
  after(stabilizer, standing(), as_planned(standing(), 0.5), 100);
  const double error = stabilizer.state().com_error.x();
  EXPECT_GT(stabilizer.state().zmp_desired.x() - standing().zmp.x(), error);
}

// Each leg is lengthened by its planned load divided by its stiffness.
TEST(Stabilizer, SharesTheLoadByTheDesiredZmpUnlessDistributionIsOff) {
  Reference to_the_left = standing();
  to_the_left.zmp.y() = 0.04;
  StabilizerOptions options = with(&StabilizerOptions::leg_compliance);
  for (const auto& [distributed, reference, left] : {std::tuple(true, to_the_left, (0.04 + 0.095) / 0.19),
                                                     {false, to_the_left, 0.5},
                                                     {true, on_the_left_foot(), 1.0}}) {
    options.distribution.enabled = distributed;
    Stabilizer stabilizer(kRobot, options);
    const Posture posture = after(stabilizer, reference, as_planned(reference, 0.5), 400);
    const double longer_left = reference.X_PL.translation().z() - posture.X_PL.translation().z(),
                 longer_right = reference.X_PR.translation().z() - posture.X_PR.translation().z();
    EXPECT_NEAR(longer_left, left * kWeight / options.leg_compliance.stiffness_n_m, 1e-9);
    EXPECT_NEAR(longer_right, (1 - left) * kWeight / options.leg_compliance.stiffness_n_m, 1e-9);
  }
}

TEST(Stabilizer, SeesNoVelocityWhenTheSupportChangesFeet) {
  Stabilizer stabilizer(kRobot, estimators_alone());
  SensorReadings readings = as_planned(standing(), 1.0);
  readings.q[7] += 0.01;  // the left hip's encoder disagrees with the plan, the right one's does not
  after(stabilizer, standing(), readings, 100);
  const Vector2d on_left = stabilizer.state().com_error;
  std::swap(readings.left, readings.right);
  stabilizer.step(standing(), readings);
  EXPECT_GT((stabilizer.state().com_error - on_left).norm(), 1e-3);
  EXPECT_LT(stabilizer.state().com_velocity_error.norm(), 1e-9);
}

TEST(Stabilizer, TurnsTheWaistAgainstItsTiltAboutTheCenterOfMass) {
  Stabilizer stabilizer(kRobot, with(&StabilizerOptions::body_attitude));
  stabilizer.step(standing(), turning(0.02, 0));
  const Posture posture = after(stabilizer, standing(), as_planned(standing(), 0.5), 20);
  EXPECT_LT(roll_of(posture.X_PB), -1e-3);
  EXPECT_LT((posture.X_PB * kRobot.com - standing().com).norm(), 1e-12);
}

TEST(Stabilizer, TurnsTheAnklesWithTheMeasuredTorque) {
  const StabilizerOptions options = with(&StabilizerOptions::ankle_admittance);
  Stabilizer stabilizer(kRobot, options);
  const Reference reference = on_the_left_foot();
  SensorReadings readings = as_planned(reference, 1.0);
  readings.left.torque.x() += 5;
  readings.left.torque.y() += 3;
  const Posture posture = after(stabilizer, reference, readings, 2);
  const double gain = options.ankle_admittance.gain_rad_s_per_nm;
  EXPECT_NEAR(roll_of(posture.X_PL), 2 * kPeriod * gain * 5, 1e-5);  // the leak takes 1/300 of the first tick
  EXPECT_NEAR(pitch_of(posture.X_PL), 2 * kPeriod * gain * 3, 1e-5);
  EXPECT_EQ(roll_of(posture.X_PR), 0);
}

TEST(Stabilizer, LowersTheFootThatCarriesTooLittle) {
  Stabilizer stabilizer(kRobot, with(&StabilizerOptions::force_difference));
  const Posture posture = after(stabilizer, standing(), as_planned(standing(), 0.3), 10);
  EXPECT_LT(posture.X_PL.translation().z(), -1e-6);
  EXPECT_DOUBLE_EQ(posture.X_PL.translation().z(), -posture.X_PR.translation().z());
}

TEST(Stabilizer, KeepsItsCorrectionsWithinTheirLimitsForAnyReadings) {
  StabilizerOptions options;
  Stabilizer stabilizer(kRobot, options);
  SensorReadings readings = as_planned(standing(), 0.5);
  readings.left.torque << 1e6, -1e6, 1e6;
  readings.right.force.z() = -1e6;
  readings.gyro << 50, -50, 50;
  const Posture posture = after(stabilizer, standing(), readings, 400);
  EXPECT_TRUE(posture.X_PB.matrix().allFinite() && posture.X_PL.matrix().allFinite() &&
              posture.X_PR.matrix().allFinite());
  EXPECT_LE(std::abs(roll_of(posture.X_PL)),
            StabilizerOptions::AnkleAdmittance{}.largest_rad + 0.01);  // roll and pitch combined
  EXPECT_LE(std::abs(posture.X_PL.translation().z()),
            kLargestFootDifference_m / 2 + kWeight / options.leg_compliance.stiffness_n_m + 1e-12);
}

}  // namespace
}  // namespace walking
