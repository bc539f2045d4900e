#include "walking/preview_control.h"

#include "tests/walking/walks.h"
#include "walking/kinematics.h"
#include "walking/timeline.h"

namespace walking {
namespace {

constexpr int kHorizon = 320;
constexpr double kGainTolerance = 1e-7;  // relative: the tables come from 60-digit arithmetic, ours is double

void expect_gain(double expected, double actual) {
  EXPECT_NEAR(actual / expected, 1, kGainTolerance) << "expected " << expected;
}

void expect_gains(const PreviewGains& gains, double integral, const std::array<double, 3>& state,
                  const std::map<int, double>& preview) {
  expect_gain(integral, gains.integral);
  for (int i = 0; i < 3; ++i) expect_gain(state[i], gains.state(i));
  for (const auto& [j, gain] : preview) expect_gain(gain, gains.preview(j - 1));
}

TEST(PreviewGains, MatchThePublishedGainsAndTheReferenceForOtherGravityAndHeights) {
  const PreviewGains gains = preview_gains(CartTable(0.814), kHorizon);
  const std::map<int, double> preview{{1, -618.7016237839},   {2, -777.5073305104},   {3, -952.2612920583},
                                      {6, -1181.389369841},   {12, -1056.464148017},  {32, -745.5674954037},
                                      {100, -229.0197332170}, {240, -20.15999313400}, {320, -5.028222646254}};
  expect_gains(gains, 618.7016237839, {72719.43894273, 21549.59769818, 177.0126567286}, preview);
  expect_gain(-72432.26696154, gains.preview.sum());
  expect_gains(preview_gains(CartTable(0.814, kPeriod, 9.80665), kHorizon), 618.6529933447,
               {72725.67854945, 21554.96027898, 177.0380718019}, {{3, -952.2540476652}});
  expect_gains(preview_gains(CartTable(0.8078), kHorizon), 619.7887522921,
               {72579.64543216, 21429.83782496, 176.4445598795}, {{3, -952.4196134829}});
}

/// Sends a reference for both axes, constant beyond its ends, tick by tick through preview control.
struct Walked {
  std::vector<PreviewControl::State> states;
  std::vector<Eigen::Vector2d> zmp;
  Eigen::Vector2d largest_error = Eigen::Vector2d::Zero();
};

Walked walk(const std::vector<Eigen::Vector2d>& reference, int horizon = kHorizon) {
  const CartTable cart(0.814);
  PreviewControl control(cart, preview_gains(cart, horizon), reference.front());
  Walked walked;
  PreviewWindow window(horizon);
  for (std::size_t k = 0; k < reference.size(); ++k) {
    for (std::size_t ahead = k == 0 ? 0 : horizon; !window.full(); ++ahead)
      window.push(reference[std::min(k + ahead, reference.size() - 1)]);
    walked.states.push_back(control.state());
    walked.zmp.push_back(control.zmp());
    walked.largest_error = walked.largest_error.cwiseMax((control.zmp() - reference[k]).cwiseAbs());
    control.advance(window);
    window.pop();
  }
  return walked;
}

std::vector<Eigen::Vector2d> step_reference() {
  std::vector<Eigen::Vector2d> reference(801, Eigen::Vector2d(0.3, 0));
  std::fill_n(reference.begin(), 400, Eigen::Vector2d::Zero());
  return reference;
}

TEST(PreviewControl, StepResponseMatchesTheReference) {
  const Walked walked = walk(step_reference());
  constexpr double kPrinted = 1e-9;  // ten decimals printed, gains good to 1e-11
  const std::map<int, std::array<double, 4>> expected{
      {80, {0, 0, 0, 0}},
      {200, {0.0043044788, 0.0171560957, 0.0556200813, -0.0003106839}},
      {300, {0.0265524646, 0.0928990999, 0.3206592101, -0.0000547318}},
      {390, {0.1271633763, 0.4416202440, 1.5415064958, -0.0007455216}},
      {399, {0.1486938167, 0.5104148572, 0.4157568955, 0.1141957420}},
      {400, {0.1512476213, 0.5104136795, -0.4162279716, 0.1857847843}},
      {410, {0.1749663945, 0.4339772984, -1.5062267100, 0.2999478972}},
      {500, {0.2737824809, 0.0910133371, -0.3159421171, 0.2999982693}},
      {800, {0.2998564080, 0.0004984757, -0.0017304011, 0.2999999907}}};
  for (const auto& [k, values] : expected) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(walked.states[k](i, 0), values[i], kPrinted) << "at " << k;
    EXPECT_NEAR(walked.zmp[k].x(), values[3], kPrinted) << "at " << k;
  }
  EXPECT_NE(walked.states[81](0, 0), 0);
  EXPECT_NEAR(walked.largest_error.x(), 0.1142152, 1e-7);
}

TEST(PreviewControl, HalfThePreviewUndershootsMore) {
  const auto expect_extremes = [](int horizon, double least, double most, double tolerance) {
    const auto zmp = walk(step_reference(), horizon).zmp;
    const auto [a, b] = std::minmax_element(zmp.begin(), zmp.end(),
                                            [](const auto& p, const auto& q) { return p.x() < q.x(); });
    EXPECT_NEAR(a->x(), least, tolerance);
    EXPECT_NEAR(b->x(), most, tolerance);
  };
  expect_extremes(kHorizon, -0.0095048, 0.3094852, 1e-7);
  expect_extremes(kHorizon / 2, -0.037704, 0.307207, 1e-6);
}

/// The whole mass at the plan's center of mass: the cart-table itself.
BodyMomentum one_mass(const BodyMotion& motion) {
  const Eigen::Vector3d offset = motion.pose.X_PB.linear() * kRobot.com;
  return {.mass = kRobot.mass,
          .com = motion.pose.X_PB.translation() + offset,
          .linear = kRobot.mass * (motion.v + motion.w.cross(offset))};
}

WalkOptions two_steps() {
  WalkOptions options = walk_of({Stand{2}, Straight{0.6, -0.1}, Stand{1}, TangentArc{0.75, 0.8}, Stand{2}});
  options.com_height_m = kRobot.base_height + kRobot.com.z();
  return options;
}

std::vector<Reference> with_second_preview(const WholeBody& model) {
  WalkOptions options = two_steps();
  options.second_preview = true;
  return planned(PatternGenerator(kRobot, options, model));
}

TEST(MotionBetween, LeadsFromOnePoseToTheOther) {
  BodyPose before, after;
  before.X_PB =
      Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, -1).normalized());
  const Eigen::Vector3d turn(0.02, -0.01, 0.03);
  after.X_PB.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * before.X_PB.linear();
  after.X_PB.translation() << 1.01, 2, 2.98;
  before.q.setZero(30);
  after.q.setConstant(30, 0.1);
  const BodyMotion motion = motion_between(before, after, kPeriod);
  EXPECT_LT((motion.w * kPeriod - turn).norm(), 1e-14);
  EXPECT_LT((motion.v - Eigen::Vector3d(2, 0, -4)).norm(), 1e-12);
  EXPECT_LT((motion.dq.array() - 20).abs().maxCoeff(), 1e-12);
  EXPECT_LT((motion.pose.q.array() - 0.05).abs().maxCoeff(), 1e-15);
  const Eigen::Matrix3d half = Eigen::AngleAxisd(turn.norm() / 2, turn.normalized()) * before.X_PB.linear();
  EXPECT_TRUE(motion.pose.X_PB.linear().isApprox(half, 1e-14));
}

TEST(MultibodyZmp, IsBelowABodyAtRestAndBehindOneWhoseUpperBodyRotatesForward) {
  BodyMomentum still{.mass = 50, .com = {3, -2, 0.8}}, turning = still;
  EXPECT_LT((multibody_zmp(still, still) - Eigen::Vector2d(3, -2)).norm(), 1e-14);
  turning.angular.y() = 50 * kGravity * kPeriod * 0.02;  // the moment that moves the ZMP 2 cm behind the mass
  EXPECT_LT((multibody_zmp(still, turning) - Eigen::Vector2d(2.98, -2)).norm(), 1e-14);
}

TEST(MultibodyZmp, OfASingleMassMatchesTheCartTable) {
  const auto walk = planned(two_steps());
  for (std::size_t k = 2; k < walk.size(); ++k) {
    const Reference &a = walk[k - 2], &b = walk[k - 1], &c = walk[k];
    const auto momentum = [](const Reference& from, const Reference& to) {
      return one_mass(
          motion_between(pose_of(kRobot, from, kRobot.posture), pose_of(kRobot, to, kRobot.posture)));
    };
    // Differences give the mean acceleration over two ticks, the cart-table the acceleration at the tick.
    const Eigen::Vector3d mean = b.com_acceleration / 1.5 + (a.com_acceleration + c.com_acceleration) / 6;
    const Eigen::Vector3d expected = b.com - two_steps().com_height_m / kGravity * mean;
    const Eigen::Vector2d found = multibody_zmp(momentum(a, b), momentum(b, c));
    ASSERT_LT((found - expected.head<2>()).norm(), 5e-5) << "at " << b.t_s;  // acceleration T² / 2
  }
}

TEST(SecondPreview, LeavesTheCartTableWithItsFeetAndHeadingAsItIs) {
  const auto first = planned(two_steps()), second = with_second_preview(one_mass);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t k = 0; k < first.size(); ++k) {
    const Reference &a = first[k], &b = second[k];
    ASSERT_EQ(a.t_s, b.t_s);
    ASSERT_LT((a.com - b.com).norm(), 0.005);  // corrects the first stage's tracking error, at most 16 mm
    ASSERT_TRUE(a.X_PL.matrix() == b.X_PL.matrix());
    ASSERT_TRUE(a.X_PR.matrix() == b.X_PR.matrix());
    ASSERT_TRUE(a.X_PB.linear() == b.X_PB.linear());
    ASSERT_LT((b.X_PB * kRobot.com - b.com).norm(), 1e-14);
    ASSERT_LT((b.waist_velocity - a.waist_velocity - (b.com_velocity - a.com_velocity)).norm(), 1e-14);
  }
}

TEST(SecondPreview, StartsHalfSittingEvenIfTheModelsMassIsElsewhere) {
  const auto walk = with_second_preview([](const BodyMotion& motion) {
    BodyMomentum momentum = one_mass(motion);
    momentum.com.y() += 0.00155;  // like the real robot's
    return momentum;
  });
  EXPECT_LT((walk.front().com.head<2>() - kRobot.com.head<2>()).norm(), 1e-15);
  EXPECT_LT(walk[1].com_acceleration.norm(), 0.1);  // m/s²; 0.56 if the offset were applied at once
  EXPECT_NEAR(walk.back().com.y() - planned(two_steps()).back().com.y(), -0.00155, 1e-4);
}

}  // namespace
}  // namespace walking
