#include "slam/sensors.h"

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

using std::chrono::milliseconds;

const Eigen::Vector3d kRateVector(0.3, -0.7, 1.1), kZero(0, 0, 0);

/// Readings of 5 ms between `from_ms` and `to_ms`, each with the given value, appended to others.
std::vector<InertialSample> readings(int from_ms, int to_ms, const Eigen::Vector3d& value,
                                     std::vector<InertialSample> samples = {}) {
  for (milliseconds t(from_ms); t < milliseconds(to_ms); t += milliseconds(5))
    samples.push_back({t, t + milliseconds(5), value});
  return samples;
}

std::optional<MeanRate> rate_of(const std::vector<InertialSample>& samples, int from_ms, int to_ms,
                                const Options& options = {}) {
  return mean_rate({milliseconds(from_ms), milliseconds(to_ms), samples, {}}, options);
}

TEST(Gyro, ReadingsOutsideTheIntervalAreLeftOutAndStraddlingOnesAreCut) {
  const auto samples = readings(50, 60, {9, 9, 9}, readings(10, 50, kRateVector, readings(0, 10, {9, 9, 9})));
  const auto rate = rate_of(samples, 13, 46);
  ASSERT_TRUE(rate);
  EXPECT_LT((rate->w_C - kRateVector).norm(), 1e-13);
  EXPECT_NEAR(rate->sigma_rad_s, 0.01 * std::sqrt(0.005 / 0.033), 1e-12);
}

TEST(Gyro, AGapAddsThePossibleChangeOfRateAndMoreThanHalfGivesNothing) {
  EXPECT_FALSE(rate_of({}, 0, 40));
  EXPECT_FALSE(rate_of(readings(0, 15, kRateVector), 0, 40));
  const auto full = rate_of(readings(0, 40, kRateVector), 0, 40),
             half = rate_of(readings(0, 20, kRateVector), 0, 40);
  EXPECT_LT((half->w_C - kRateVector).norm(), 1e-13);  // still a rate, not one with zeros averaged in
  EXPECT_GT(half->sigma_rad_s, 5 * full->sigma_rad_s);
}

TEST(Gyro, OnlyTheLastReadingIsTheRateAtTheFrame) {
  Options options;
  options.gyro.readings = GyroReadings::last;
  const auto rate = rate_of(readings(25, 30, 2 * kRateVector, readings(0, 25, kRateVector)), 0, 30, options);
  ASSERT_TRUE(rate);
  EXPECT_EQ(rate->w_C, Eigen::Vector3d(2 * kRateVector));
  EXPECT_EQ(rate->sigma_rad_s, options.gyro.sigma_rad_s);
  EXPECT_FALSE(rate_of({}, 0, 30, options));
}

synthetic::Walk noise_free() {
  synthetic::Walk walk;
  walk.gyro_sigma_rad_s = walk.accelerometer_sigma_m_s2 = 0;
  return walk;
}

/// A camera on a neck that nods and yields, in the frame of the recording's camera.
Eigen::Isometry3d nodding(Stamp t) {
  Eigen::Isometry3d X_RC(Eigen::AngleAxisd(0.1 * std::sin(3 * seconds(t)), Eigen::Vector3d(0.6, 0, 0.8)));
  X_RC.translation() << 0, 0.02 * std::cos(2 * seconds(t)), 0.01 * seconds(t);
  return X_RC;
}

InertialInterval interval(const synthetic::Recording& recording, int frame) {
  const Observation o = recording.observation(frame);
  const Stamp from = recording.walk().stamp(frame - 1);
  const auto X_CG = [](Stamp t) { return nodding(t).inverse() * synthetic::calibration().X_CG; };
  return {from, o.t, o.gyro, o.accelerometer, X_CG(from), X_CG(o.t)};
}

Eigen::Isometry3d X_WC(const synthetic::Recording& recording, Stamp t) {
  return recording.walk().X_WC(seconds(t)) * nodding(t);
}

TEST(Gyro, RotatesTheNoddingCameraOfAWalkExactlyAsItTurned) {
  const synthetic::Recording recording(noise_free());
  for (const int frame : {40, 100, 301}) {
    const InertialInterval whole = interval(recording, frame);
    const auto [from, to] = std::pair(whole.from, whole.to);
    const auto rate = mean_rate(whole, Options{});
    ASSERT_TRUE(rate);
    const auto R_WC = [&](Stamp t) -> Eigen::Matrix3d { return X_WC(recording, t).linear(); };
    const Eigen::Matrix3d turned = R_WC(from).transpose() * R_WC(to);
    const Eigen::Vector4d q = quaternion_exp(rate->w_C * seconds(to - from));
    EXPECT_NEAR((rotation_matrix(q) - turned).norm(), 0, 1e-12);
  }
}

TEST(Accelerometer, IncrementIsTheChangeOfTheCamerasMeanVelocityAndIsAbsentIfReadingsAreMissing) {
  const synthetic::Recording recording(noise_free());
  for (int frame = 60; frame < 140; frame += 7) {
    const InertialInterval earlier = interval(recording, frame);
    InertialInterval later = interval(recording, frame + 1);
    const auto increment = velocity_increment(earlier, later, kZero, Options{});
    ASSERT_TRUE(increment);
    const auto velocity = [&](const InertialInterval& i) -> Eigen::Vector3d {
      return (X_WC(recording, i.to).translation() - X_WC(recording, i.from).translation()) /
             seconds(i.to - i.from);
    };
    const Eigen::Vector3d measured = X_WC(recording, later.from).linear() * increment->increment_C +
                                     increment->duration_s * Eigen::Vector3d(0, 0, -9.81);
    // m/s: the acceleration is assumed constant over readings of 5 ms
    EXPECT_NEAR((measured - velocity(later) + velocity(earlier)).norm(), 0, 3e-5);
    later.accelerometer.erase(later.accelerometer.begin() + 2);
    EXPECT_FALSE(velocity_increment(earlier, later, kZero, Options{}));
  }
}

const PlannedVelocity kPlanned{{0.2, -0.1, 0.05}, {0.1, 0.3, -0.2}, {0.1, 1.3, -0.2}, {0.15, 0.05, 0.2}};

Eigen::Vector3d innovation(const RobotVector& x, const PlannedVelocity& planned,
                           const Options::PlanVelocity& options) {
  return measure_velocity(x, planned, options).innovation;
}

Options::PlanVelocity plan_options(VelocityAxes axes, bool pivots_on_foot) {
  Options::PlanVelocity options;
  options.axes = axes, options.pivots_on_foot = pivots_on_foot;
  return options;
}

TEST(Plan, VelocityInTheRobotsAxesDoesNotDependOnTheHeading) {
  const RobotVector x = generic_state();
  const Eigen::Vector4d turn = quaternion_exp({0, 0, 1.3});
  RobotVector turned = x, flipped = x;
  turned.segment<4>(kOrientation) = quaternion_product(turn, x.segment<4>(kOrientation));
  turned.segment<3>(kVelocity) = rotation_matrix(turn) * x.segment<3>(kVelocity);
  flipped.segment<4>(kOrientation) *= -1;  // another sign of the quaternion is the same orientation
  EXPECT_LT((innovation(x, kPlanned, {}) - innovation(turned, kPlanned, {})).norm(), 1e-14);
  EXPECT_EQ(innovation(flipped, kPlanned, {}), innovation(x, kPlanned, {}));
  const auto world = plan_options(VelocityAxes::plan, true);
  EXPECT_GT((innovation(x, kPlanned, world) - innovation(turned, kPlanned, world)).norm(), 0.1);
}

/// The pose, after t, of the camera of a body that stands as planned but tilts about its foot.
Eigen::Isometry3d tilted(const Eigen::Vector3d& w_W, const Eigen::Vector3d& foot_W, double t) {
  return Eigen::Translation3d(foot_W) * pose(w_W.norm() * t, w_W, kZero) * Eigen::Translation3d(-foot_W) *
         pose(0.7, {1, -1, 2}, {0.3, 0.1, 1.4});
}

TEST(Plan, ABodyTiltingAboutItsFootMovesItsCameraAsModeledExceptInHeight) {
  const Eigen::Vector3d w_W(0.2, -0.1, 0.05), foot_W(0.2, -0.1, 0);
  const Eigen::Isometry3d now = tilted(w_W, foot_W, 0), later = tilted(w_W, foot_W, 1e-6),
                          earlier = tilted(w_W, foot_W, -1e-6);
  RobotVector x = RobotVector::Zero();
  const Eigen::Quaterniond q(now.linear());
  x.segment<4>(kOrientation) << q.w(), q.x(), q.y(), q.z();
  x.segment<3>(kVelocity) = (later.translation() - earlier.translation()) / 2e-6;
  x.segment<3>(kRate) = now.linear().transpose() * w_W;
  const PlannedVelocity standing{kZero, kZero, now.inverse() * foot_W};
  const Eigen::Vector3d left = now.linear() * innovation(x, standing, {});
  EXPECT_LT(left.head<2>().norm(), 1e-9);  // rounding 1e-16 / step 1e-6
  EXPECT_NEAR(left.z(), -x(kVelocity + 2), 1e-9);
  EXPECT_GT(innovation(x, standing, plan_options(VelocityAxes::robot, false)).norm(), 0.2);
}

TEST(Plan, StrideLengthStrideAngleAndSwayErrorsChangeThePlannedVelocity) {
  RobotVector x = RobotVector::Zero();
  x.segment<4>(kOrientation) = generic_state().segment<4>(kOrientation);
  x.segment<2>(kStrideError) << 0.02, 0.05;
  const Eigen::Vector3d sway_C(-0.01, 0.02, 0.04), planned_C(0.2, 0.03, -0.1);
  x.segment<3>(kSwayVelocity) = sway_C;
  // The stride errors: 2 % of the horizontal planned velocity, plus 0.05 times this velocity turned to the
  // side.
  const Eigen::Vector3d true_C = planned_C - sway_C - Eigen::Vector3d(0.004 + 0.005, 0, -0.002 + 0.01);
  const Eigen::Matrix3d R_WC = rotation_matrix(x.segment<4>(kOrientation));
  x.segment<3>(kVelocity) = R_WC * true_C;
  PlannedVelocity stride{planned_C, kZero, kZero, planned_C};
  EXPECT_LT(innovation(x, stride, plan_options(VelocityAxes::robot, false)).norm(), 1e-15);
  stride.velocity = R_WC * planned_C;
  EXPECT_LT(innovation(x, stride, plan_options(VelocityAxes::plan, false)).norm(), 1e-15);
}

TEST(Plan, TheVelocityDependsOnTheScaleOfItsSource) {
  const Measurement plan = measure_velocity(generic_state(), kPlanned, {}),
                    legs = measure_velocity(generic_state(), kPlanned, {}, kLegScale);
  EXPECT_EQ(plan.H_robot, legs.H_robot);
  EXPECT_EQ(Eigen::Vector3d(plan.sensitivity.col(kPlanScale)), kPlanned.steady_C);
  EXPECT_EQ(legs.sensitivity.col(kLegScale), plan.sensitivity.col(kPlanScale));
  EXPECT_EQ(plan.sensitivity.col(kLegScale).norm() + legs.sensitivity.col(kPlanScale).norm(), 0);
}

/// The motion between two frames 0.1 s apart.
PlannedInterval moved(const Observation& before, const Observation& now, const Options& options) {
  PlanHistory history;
  EXPECT_FALSE(history.advance(before, 0, options));
  return history.advance(now, 0.1, options).value();
}

TEST(PlanHistory, GivesTheMeanVelocityBetweenTwoConsecutiveFramesWithAPlan) {
  Options along_robot, along_plan;
  along_plan.plan_velocity.axes = VelocityAxes::plan;
  Observation before, now;
  PlannedMotion &from = before.plan.emplace(), &to = now.plan.emplace();
  from.X_PC = pose(0.4, {0, 0, 1}, {1, 2, 1.4});
  to.X_PC = from.X_PC * pose(0.02, {1, 2, 3}, kZero);
  to.X_PC.translation() += Eigen::Vector3d(0.03, -0.01, 0.005);
  from.p_CF = {0, 1.4, 0};
  to.p_CF = {0.02, 1.4, 0.04};
  const PlannedVelocity world = *moved(before, now, along_plan).plan,
                        robot = *moved(before, now, along_robot).plan;
  EXPECT_LT((world.velocity - Eigen::Vector3d(0.3, -0.1, 0.05)).norm(), 1e-14);
  EXPECT_LT((to.X_PC.linear() * robot.velocity - world.velocity).norm(), 1e-14);
  EXPECT_LT((robot.rate - 0.2 * Eigen::Vector3d(1, 2, 3).normalized()).norm(), 1e-13);
  EXPECT_LT((robot.p_CF - Eigen::Vector3d(0.01, 1.4, 0.02)).norm(), 1e-15);
  EXPECT_EQ(robot.sigma_m_s, along_robot.plan_velocity.sigma_m_s);
  EXPECT_FALSE(moved(before, now, along_robot).standing);
  EXPECT_TRUE(moved(before, before, along_robot).standing);
  PlanHistory history;
  for (const auto& one : {now, Observation(), now}) EXPECT_FALSE(history.advance(one, 0.1, {}));
}

TEST(PlanHistory, LegOdometryReplacesThePlanIfItIsGivenAlongTheRobotsAxes) {
  Options options, along_plan, disabled;
  along_plan.plan_velocity.axes = VelocityAxes::plan;
  disabled.leg_odometry.enabled = false;
  Observation before, now, without_legs;
  before.plan.emplace(), without_legs.plan.emplace();
  now.plan.emplace().X_PC.translation().x() = 0.03;
  before.legs = LegMotion{Eigen::Isometry3d::Identity(), {0, 1.4, 0}};
  now.legs = LegMotion{pose(0.01, {0, 1, 0}, {0, 0, 0.02}), {0, 1.4, -0.04}};
  const PlannedInterval interval = moved(before, now, options);
  EXPECT_NEAR(interval.plan->velocity.x(), 0.3, 1e-15);
  ASSERT_TRUE(interval.legs);
  const Eigen::Vector3d v_O(0, 0, 0.2);
  EXPECT_LT((interval.legs->velocity - now.legs->X_OC.linear().transpose() * v_O).norm(), 1e-15);
  EXPECT_LT((interval.legs->rate - Eigen::Vector3d(0, 0.1, 0)).norm(), 1e-12);
  EXPECT_EQ(interval.legs->p_CF, Eigen::Vector3d(0, 1.4, -0.02));
  EXPECT_EQ(interval.legs->steady_C, interval.plan->steady_C);
  EXPECT_FALSE(moved(before, now, along_plan).legs);
  EXPECT_FALSE(moved(before, now, disabled).legs);
  EXPECT_FALSE(moved(without_legs, now, options).legs);
  before.plan.reset();
  const PlannedInterval alone = moved(before, now, options);
  EXPECT_FALSE(alone.plan);
  EXPECT_EQ(alone.legs->velocity, interval.legs->velocity);
  EXPECT_GT(alone.legs->steady_C.z(), 0);
}

TEST(PlanHistory, ACommandIsFollowedWithALagAndOnlyWithoutAPlanOrLegOdometry) {
  PlanHistory history;
  Options options, disabled;
  disabled.command.enabled = false;
  Observation now;
  now.command = CommandedVelocity{Stamp(0), 0.4, -0.2, 9};
  EXPECT_LT((*history.advance(now, options.command.lag_s, options)->command -
             (1 - std::exp(-1)) * Eigen::Vector2d(0.4, -0.2))
                .norm(),
            1e-15);
  EXPECT_FALSE(history.advance(now, 0.1, disabled));
  now.legs.emplace();
  history.advance(now, 0.1, options);
  EXPECT_FALSE(history.advance(now, 0.1, options)->command);
}

/// A robot that walks along y of the plan's world with a step of 0.1 m in every eight frames. Plan and
/// odometry are in worlds that are rotated relative to each other. sways_m: sideways, alternately to each
/// side.
std::vector<Observation> stepping(double scale, double sways_m = 0) {
  Eigen::Isometry3d X_PC = Eigen::Isometry3d::Identity();
  X_PC.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;  // z of C is y of P
  const Eigen::Isometry3d X_OP = pose(1.2, {0, 0, 1}, {3, 4, 0});
  std::vector<Observation> frames;
  for (int k = 0; k < 8; ++k) {
    X_PC.translation() << (k % 2 == 0 ? sways_m : -sways_m), 0.1 * k, 1.4;
    frames.emplace_back().legs = LegMotion{X_OP * X_PC, kZero};
    X_PC.translation() << 0, 0.1 * scale * k, 1.4;
    frames.back().plan =
        PlannedMotion{X_PC, kZero, kZero, kZero, k % 2 == 0 ? Support::left : Support::right};
  }
  return frames;
}

std::vector<SystematicEvidence> evidence(const std::vector<Observation>& frames) {
  PlanHistory history;
  std::vector<SystematicEvidence> all;
  for (const Observation& frame : frames)
    if (const auto interval = history.advance(frame, 0.8, {})) all.push_back(interval->plan_scale);
  return all;
}

TEST(PlanHistory, LegOdometryRevealsTheScaleOfThePlanEveryTwoSteps) {
  for (const double sways_m : {0.0, 0.03}) {
    const auto all = evidence(stepping(1.1, sways_m));
    for (const std::size_t k : {0U, 1U, 3U, 5U}) EXPECT_EQ(all[k].information, 0) << k;  // a landing starts
    for (const std::size_t k : {2U, 4U, 6U}) {
      EXPECT_NEAR(all[k].score / all[k].information, 0.1, 1e-12) << k;
      const double change_m = k == 2 ? 0.22 : 0;  // from standing
      EXPECT_NEAR(all[k].information, 0.2 * 0.2 / (0.005 * 0.005 + change_m * change_m), 1e-9) << k;
    }
  }
}

TEST(PlanHistory, TwoStepsUnlikeThoseBeforeRevealLittleAboutTheScale) {
  std::vector<Observation> frames = stepping(1);
  const Eigen::Isometry3d X_OP = frames[0].legs->X_OC * frames[0].plan->X_PC.inverse();
  for (std::size_t k = 4; k < frames.size(); ++k) {
    frames[k].plan->X_PC.translation().y() += 0.2 * static_cast<double>(k - 3);
    frames[k].legs->X_OC = X_OP * frames[k].plan->X_PC;
  }
  const auto all = evidence(frames);
  EXPECT_NEAR(all[4].information, 0.6 * 0.6 / (0.005 * 0.005 + 0.4 * 0.4), 1e-9);
  EXPECT_NEAR(all[6].information, 0.6 * 0.6 / (0.005 * 0.005), 1e-6);
}

TEST(PlanHistory, TheComparisonRestartsWhileThePlanStandsOrLegOdometryIsMissing) {
  auto without_legs = stepping(1), standing = stepping(1);
  without_legs[2].legs.reset();
  standing[2].plan->X_PC = standing[1].plan->X_PC;
  for (const auto& all : {evidence(standing), evidence(without_legs)}) {
    for (const std::size_t k : {0U, 1U, 2U, 3U, 5U}) EXPECT_EQ(all[k].information, 0) << k;
    for (const std::size_t k : {4U, 6U}) EXPECT_GT(all[k].information, 0) << k;
  }
}

TEST(PlanHistory, LegOdometryIsLessCertainWhileTheRobotTurnsDifferentlyFromItsLegs) {
  Options options;
  options.leg_odometry.sigma_m_s = 0.03, options.leg_odometry.sigma_pivot_m = 0.1;
  PlanHistory history;
  Observation now;
  now.plan.emplace(), now.legs.emplace();
  history.advance(now, 0, options);
  const PlannedInterval interval = *history.advance(now, 0.03, options);
  RobotVector x = generic_state();
  x.segment<3>(kRate) << 0, 0.4, 0;
  EXPECT_NEAR(measure_velocity(x, *interval.legs, {}).R(1, 1), 0.03 * 0.03 + 0.04 * 0.04, 1e-12);
  EXPECT_NEAR(measure_velocity(x, *interval.plan, {}).R(1, 1), 0.02 * 0.02, 1e-12) << "not the plan";
}

TEST(PlanHistory, TheSteadyVelocityIsKnownAfterTwoSteps) {
  PlanHistory history;
  Observation now;
  now.plan.emplace();
  history.advance(now, 0, {});
  for (const auto& [dt_s, ahead_m, steady] :
       {std::tuple{1.5, 0.0, false}, {0.5, 0.01, false}, {1.0, 0.0, false}, {0.2, 0.01, true}}) {
    now.plan->X_PC.translation().x() += ahead_m;
    EXPECT_EQ(history.advance(now, dt_s, {})->steady, steady) << dt_s;
  }
}

TEST(PlanHistory, TheSteadyVelocityOfASwayingWalkIsItsMean) {
  PlanHistory history;
  Observation now;
  now.plan.emplace();
  Eigen::Vector3d steady_C = kZero;
  for (int k = 0; k < 400; ++k) {  // 8 s, swaying in 1.6 s by four times the mean velocity
    now.plan->X_PC.translation().x() += 0.02 * (0.05 + 0.2 * std::sin(6.2831853 * k / 80));
    if (const auto interval = history.advance(now, 0.02, {})) steady_C = interval->plan->steady_C;
  }
  EXPECT_NEAR(steady_C.x(), 0.05, 0.2 / 6.28 + 0.001);  // a first-order mean leaves 1/2π of the swaying
  EXPECT_EQ(steady_C.z(), 0);
}

}  // namespace
}  // namespace slam
