#include "slam/plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slam {
namespace {

RobotVector generic_state() {
  RobotVector x = RobotVector::LinSpaced(-0.4, 0.9);
  x.segment<4>(kOrientation) = Eigen::Vector4d(0.9, 0.1, -0.2, 0.3).normalized();
  return x;
}

const PlannedVelocity kPlanned{{0.2, -0.1, 0.05}, {0.1, 0.3, -0.2}, {0.1, 1.3, -0.2}, {0.15, 0.05, 0.2}};

Eigen::Isometry3d pose(double angle, const Eigen::Vector3d& axis, const Eigen::Vector3d& at) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(angle, axis.normalized()).matrix();
  X.translation() = at;
  return X;
}

TEST(Plan, VelocityNoiseIsTheOneGiven) {
  Options::PlanVelocity options;
  PlannedVelocity planned = kPlanned;
  planned.sigma_m_s = 0.2;
  const auto R = measure_velocity(generic_state(), planned, options).R;
  EXPECT_LT((R - 0.04 * Eigen::Matrix3d::Identity()).norm(), 1e-16);
}

TEST(Plan, VelocityInTheRobotsAxesDoesNotDependOnTheHeading) {
  RobotVector x = generic_state();
  const Eigen::Vector4d turn = quaternion_exp({0, 0, 1.3});
  RobotVector turned = x;
  turned.segment<4>(kOrientation) = quaternion_product(turn, x.segment<4>(kOrientation));
  turned.segment<3>(kVelocity) = rotation_matrix(turn) * x.segment<3>(kVelocity);
  Options::PlanVelocity options;
  const auto innovation = [&](const RobotVector& at) {
    return Eigen::Vector3d(measure_velocity(at, kPlanned, options).innovation);
  };
  EXPECT_LT((innovation(x) - innovation(turned)).norm(), 1e-14);
  options.axes = VelocityAxes::plan;
  EXPECT_GT((innovation(x) - innovation(turned)).norm(), 0.1);
}

TEST(Plan, VelocityDoesNotDependOnTheSignOfTheQuaternion) {
  RobotVector flipped = generic_state();
  flipped.segment<4>(kOrientation) *= -1;
  EXPECT_EQ(Eigen::Vector3d(measure_velocity(flipped, kPlanned, {}).innovation),
            Eigen::Vector3d(measure_velocity(generic_state(), kPlanned, {}).innovation));
}

TEST(Plan, VelocityIsTheMeanBetweenTwoPlannedPoses) {
  PlannedMotion before, now;
  before.X_PC = pose(0.4, {0, 0, 1}, {1, 2, 1.4});
  now.X_PC = before.X_PC * pose(0.02, {1, 2, 3}, Eigen::Vector3d::Zero());
  now.X_PC.translation() += Eigen::Vector3d(0.03, -0.01, 0.005);
  before.p_CF = {0, 1.4, 0};
  now.p_CF = {0.02, 1.4, 0.04};
  const PlannedVelocity world = planned_velocity(before, now, 0.1, VelocityAxes::plan);
  const PlannedVelocity robot = planned_velocity(before, now, 0.1, VelocityAxes::robot);
  EXPECT_LT((world.velocity - Eigen::Vector3d(0.3, -0.1, 0.05)).norm(), 1e-14);
  EXPECT_LT((now.X_PC.linear() * robot.velocity - world.velocity).norm(), 1e-14);
  EXPECT_LT((robot.rate - 0.2 * Eigen::Vector3d(1, 2, 3).normalized()).norm(), 1e-13);
  EXPECT_LT((robot.p_CF - Eigen::Vector3d(0.01, 1.4, 0.02)).norm(), 1e-15);
}

TEST(Plan, AStandingPlanHasNoVelocity) {
  PlannedMotion standing;
  standing.X_PC = pose(0.4, {0, 0, 1}, {1, 2, 1.4});
  const PlannedVelocity stride = planned_velocity(standing, standing, 0.1, VelocityAxes::robot);
  EXPECT_LT(stride.velocity.norm(), 1e-15);
  EXPECT_LT(stride.rate.norm(),
            1e-7);  // the angle of a rotation matrix that is the identity but for rounding
  EXPECT_TRUE(stride.rate.allFinite());
}

/// The camera pose after t of a body that stands by its plan but tilts about its foot.
Eigen::Isometry3d tilted(const Eigen::Vector3d& w_W, const Eigen::Vector3d& foot_W, double t) {
  const Eigen::Isometry3d start = pose(0.7, {1, -1, 2}, {0.3, 0.1, 1.4});
  const Eigen::Isometry3d about = Eigen::Translation3d(foot_W) *
                                  pose(w_W.norm() * t, w_W, Eigen::Vector3d::Zero()) *
                                  Eigen::Translation3d(-foot_W);
  return about * start;
}

TEST(Plan, ABodyTiltingAboutItsFootMovesItsCameraAsTheModelSaysButForItsHeight) {
  const Eigen::Vector3d w_W(0.2, -0.1, 0.05), foot_W(0.2, -0.1, 0);
  const Eigen::Isometry3d now = tilted(w_W, foot_W, 0), later = tilted(w_W, foot_W, 1e-6),
                          earlier = tilted(w_W, foot_W, -1e-6);
  RobotVector x = RobotVector::Zero();
  const Eigen::Quaterniond q(now.linear());
  x.segment<4>(kOrientation) << q.w(), q.x(), q.y(), q.z();
  x.segment<3>(kVelocity) = (later.translation() - earlier.translation()) / 2e-6;
  x.segment<3>(kRate) = now.linear().transpose() * w_W;
  const PlannedVelocity standing{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), now.inverse() * foot_W};
  Options::PlanVelocity options;
  const Eigen::Vector3d left =
      now.linear() * Eigen::Vector3d(measure_velocity(x, standing, options).innovation);
  EXPECT_LT(left.head<2>().norm(), 1e-9);  // rounding 1e-16 / step 1e-6
  EXPECT_NEAR(left.z(), -x(kVelocity + 2), 1e-9);
  options.pivots_on_foot = false;
  EXPECT_GT(measure_velocity(x, standing, options).innovation.norm(), 0.2);
}

TEST(Plan, SwayingIsPlannedMinusTrueVelocity) {
  RobotVector x = generic_state();
  x.segment<3>(kSwayVelocity) << -0.01, 0.02, 0.04;
  Options::PlanVelocity options;
  options.pivots_on_foot = false;
  const Eigen::Vector3d v_C =
      rotation_matrix(x.segment<4>(kOrientation)).transpose() * x.segment<3>(kVelocity);
  x.segment<2>(kStrideError).setZero();
  const PlannedVelocity stride{v_C + x.segment<3>(kSwayVelocity), {0, 0, 0}, {0, 0, 0}};
  EXPECT_LT(measure_velocity(x, stride, options).innovation.norm(), 1e-15);
}

TEST(Plan, StridesTooLongAndTurnedMakeThePlannedVelocityTooFastAndTurned) {
  RobotVector x = RobotVector::Zero();
  x.segment<4>(kOrientation) = generic_state().segment<4>(kOrientation);
  x.segment<2>(kStrideError) << 0.02, 0.05;
  const Eigen::Vector3d planned_C(0.2, 0.03, -0.1);
  // 2 % of it, and 0.05 of it turned aside
  const Eigen::Vector3d true_C = planned_C - Eigen::Vector3d(0.004 + 0.005, 0, -0.002 + 0.01);
  const Eigen::Matrix3d R_WC = rotation_matrix(x.segment<4>(kOrientation));
  x.segment<3>(kVelocity) = R_WC * true_C;
  Options::PlanVelocity options;
  options.pivots_on_foot = false;
  PlannedVelocity stride{planned_C, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), planned_C};
  EXPECT_LT(measure_velocity(x, stride, options).innovation.norm(), 1e-15);
  options.axes = VelocityAxes::plan;
  stride.velocity = R_WC * planned_C;
  EXPECT_LT(measure_velocity(x, stride, options).innovation.norm(), 1e-15);
}

TEST(Plan, HistoryGivesTheVelocityWithItsSteadyPartIfTwoFramesInARowHaveAPlan) {
  const Options options;
  PlannedMotion before, now;
  now.X_PC.translation().x() = 0.03;
  PlanHistory history;
  EXPECT_FALSE(history.advance(before, 0, options));
  const auto interval = history.advance(now, 0.1, options);
  ASSERT_TRUE(interval);
  EXPECT_NEAR(interval->plan.velocity.x(), 0.3, 1e-15);
  EXPECT_NEAR(interval->plan.steady_C.x(), 0.3 * (1 - std::exp(-0.1 / 1.6)),
              1e-15);  // low-pass over two steps
  EXPECT_EQ(interval->plan.sigma_m_s, options.plan_velocity.sigma_m_s);
  EXPECT_FALSE(interval->legs);
  EXPECT_FALSE(history.advance(std::nullopt, 0.1, options));
  EXPECT_FALSE(history.advance(now, 0.1, options));
}

TEST(Plan, LegOdometryReplacesThePlanIfItIsGivenAlongTheRobotsAxes) {
  Options options;
  PlannedMotion before, now;
  now.X_PC.translation().x() = 0.03;
  before.legs.emplace(), now.legs.emplace();
  before.legs->p_CS = {0, 1.4, 0}, now.legs->p_CS = {0, 1.4, -0.04};
  now.legs->X_OC = pose(0.01, {0, 1, 0}, {0, 0, 0.02});
  const auto moved = [&] {
    PlanHistory history;
    history.advance(before, 0, options);
    return *history.advance(now, 0.1, options);
  };
  const PlannedInterval interval = moved();
  EXPECT_NEAR(interval.plan.velocity.x(), 0.3, 1e-15);
  ASSERT_TRUE(interval.legs);
  const Eigen::Vector3d v_O(0, 0, 0.2);
  EXPECT_LT((interval.legs->velocity - now.legs->X_OC.linear().transpose() * v_O).norm(), 1e-15);
  EXPECT_LT((interval.legs->rate - Eigen::Vector3d(0, 0.1, 0)).norm(), 1e-12);
  EXPECT_EQ(interval.legs->p_CF, Eigen::Vector3d(0, 1.4, -0.02));
  EXPECT_EQ(interval.legs->steady_C, interval.plan.steady_C);
  EXPECT_EQ(interval.legs->sigma_m_s, options.leg_odometry.sigma_m_s);
  options.plan_velocity.axes = VelocityAxes::plan;
  EXPECT_FALSE(moved().legs);
  options.plan_velocity.axes = VelocityAxes::robot;
  options.leg_odometry.enabled = false;
  EXPECT_FALSE(moved().legs);
  options.leg_odometry.enabled = true;
  before.legs.reset();
  EXPECT_FALSE(moved().legs) << "without an interval";
}

TEST(Plan, TheVelocityDependsOnTheScaleOfItsSource) {
  const Measurement plan = measure_velocity(generic_state(), kPlanned, {}),
                    legs = measure_velocity(generic_state(), kPlanned, {}, kLegScale);
  EXPECT_EQ(plan.H_robot, legs.H_robot);
  EXPECT_EQ(Eigen::Vector3d(plan.sensitivity.col(kPlanScale)), kPlanned.steady_C);
  EXPECT_EQ(legs.sensitivity.col(kLegScale), plan.sensitivity.col(kPlanScale));
  EXPECT_EQ(plan.sensitivity.col(kLegScale).norm() + legs.sensitivity.col(kPlanScale).norm(), 0);
}

/// A robot that walks ahead along y of the plan's world, a step of 0.1 m in each of eight frames, with its
/// plan and its odometry, whose worlds are turned against each other. sways_m: sideways, to each side in
/// turn.
std::vector<PlannedMotion> stepping(double scale, double sways_m = 0) {
  Eigen::Matrix3d looking_along_y;  // z of C is y of P
  looking_along_y << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const Eigen::Isometry3d X_OP = pose(1.2, {0, 0, 1}, {3, 4, 0});
  std::vector<PlannedMotion> frames(8);
  for (int k = 0; k < 8; ++k) {
    PlannedMotion& m = frames[static_cast<std::size_t>(k)];
    m.support = k % 2 == 0 ? Support::left : Support::right;
    Eigen::Isometry3d X_PC = Eigen::Isometry3d::Identity();
    X_PC.linear() = looking_along_y;
    X_PC.translation() << (k % 2 == 0 ? sways_m : -sways_m), 0.1 * k, 1.4;
    m.legs = LegMotion{X_OP * X_PC, {}};
    X_PC.translation() << 0, 0.1 * scale * k, 1.4;
    m.X_PC = X_PC;
  }
  return frames;
}

/// The evidence of each of the frames from 1 on.
std::vector<SystematicEvidence> evidence(const std::vector<PlannedMotion>& frames,
                                         std::size_t stands_at = 0) {
  TwoSteps two_steps;
  std::vector<SystematicEvidence> all;
  for (std::size_t k = 1; k < frames.size(); ++k)
    all.push_back(two_steps.add(frames[k - 1], frames[k], k == stands_at));
  return all;
}

TEST(Plan, EveryTwoStepsLegOdometryTellsTheScaleOfThePlan) {
  for (const double sways_m : {0.0, 0.03}) {
    const auto all = evidence(stepping(1.1, sways_m));
    for (const std::size_t k : {0, 1, 3, 5})
      EXPECT_EQ(all[k].information, 0) << k;  // the first landing starts
    for (const std::size_t k : {2U, 4U, 6U}) {
      EXPECT_NEAR(all[k].score / all[k].information, 0.1, 1e-12) << k;
      EXPECT_NEAR(all[k].information, 0.2 * 0.2 / (0.005 * 0.005), 1e-9) << k;
    }
  }
}

TEST(Plan, TwoStepsStartAnewWhileThePlanStandsAndWithoutLegOdometry) {
  auto without_legs = stepping(1);
  without_legs[2].legs.reset();
  for (const auto& all : {evidence(stepping(1), 2), evidence(without_legs)}) {
    for (const std::size_t k : {0U, 1U, 2U, 3U, 5U}) EXPECT_EQ(all[k].information, 0) << k;
    for (const std::size_t k : {4U, 6U}) EXPECT_GT(all[k].information, 0) << k;
  }
}

TEST(Plan, HeightIsThatOfTheCamera) {
  Options::Height options;
  options.sigma_m = 0.02;
  const Measurement m = measure_height(generic_state(), 1.5, options);
  EXPECT_NEAR(m.innovation(0), 1.5 - generic_state()(2), 1e-15);
  EXPECT_NEAR(m.R(0, 0), 0.0004, 1e-18);
}

TEST(Plan, LegOdometryIsLessCertainJustAfterALanding) {
  const Options::LegOdometry options;
  PlannedMotion left, right;
  left.support = Support::left, right.support = Support::right;
  const PlannedVelocity still{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, ahead{{0.2, 0, 0}, {0, 0.5, 0}, {0, 0, 0}};
  EXPECT_TRUE(planned_gait(left, left, still, {}, 0.03, 1.6).standing);
  const Gait walking = planned_gait(left, left, ahead, {}, 0.03, 1.6);
  EXPECT_FALSE(walking.standing);
  EXPECT_EQ(leg_velocity_sigma(walking, options), options.sigma_m_s);
  const Gait landing = planned_gait(left, right, ahead, walking, 0.03, 1.6);
  EXPECT_EQ(landing.since_landing_s, 0);
  EXPECT_EQ(leg_velocity_sigma(landing, options), 6 * options.sigma_m_s);
  EXPECT_NEAR(planned_gait(right, right, ahead, landing, 0.03, 1.6).since_landing_s, 0.03, 1e-15);
  EXPECT_EQ(leg_velocity_sigma(planned_gait(right, right, ahead, landing, 0.2, 1.6), options),
            options.sigma_m_s);
}

TEST(Plan, ASwayingWalksSteadyVelocityIsItsMean) {
  PlannedMotion before, now;
  Gait gait;
  constexpr double kDt_s = 0.02;
  for (int k = 0; k < 400; ++k) {  // 8 s, swaying in 1.6 s by four times the mean velocity
    now.X_PC.translation().x() += kDt_s * (0.05 + 0.2 * std::sin(6.2831853 * k / 80));
    gait = planned_gait(before, now, planned_velocity(before, now, kDt_s, VelocityAxes::robot), gait, kDt_s,
                        1.6);
    before = now;
  }
  EXPECT_NEAR(gait.steady_C.x(), 0.05, 0.2 / 6.28 + 0.001);  // a first-order mean leaves 1/2π of the swaying
  EXPECT_EQ(gait.steady_C.z(), 0);
}

}  // namespace
}  // namespace slam
