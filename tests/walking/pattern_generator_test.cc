#include "walking/pattern_generator.h"

#include "tests/walking/walks.h"

namespace walking {
namespace {

constexpr double kPi = std::numbers::pi;

/// The paper's first experiment. turn = +1: diagonally to the right, then four quarters to the left; -1:
/// mirrored.
WalkOptions tangent_circle(double turn = 1) {
  WalkOptions options;
  options.commands = {Stand{2.0}, Straight{1.0, -0.5 * turn}};
  for (int i = 0; i < 4; ++i) {
    options.commands.emplace_back(Stand{1.0});
    options.commands.emplace_back(TangentArc{0.75, turn * kPi / 2});
  }
  options.commands.emplace_back(Stand{2.0});
  return options;
}

/// The paper's second experiment, with the timing of its second trial.
WalkOptions perpendicular_circle(double turn = 1) {
  WalkOptions options;
  options.single_support_s = 0.75;
  options.double_support_s = 0.05;
  options.step_height_m = 0.04;
  options.step_length_m = 0.10;
  options.commands = {Stand{2.0}, PerpendicularArc{0.75, turn * 2 * kPi}, Stand{2.0}};
  return options;
}

void expect_pose(const Eigen::Isometry3d& X, const Eigen::Vector3d& place, double yaw, double tolerance) {
  EXPECT_LT((X.translation() - place).norm(), tolerance);
  EXPECT_NEAR(std::remainder(yaw_of(X) - yaw, 2 * kPi), 0, tolerance);
}

void expect_mirrored(const Eigen::Isometry3d& one, const Eigen::Isometry3d& two) {
  expect_pose(one, two.translation().cwiseProduct(Eigen::Vector3d(1, -1, 1)), -yaw_of(two), 1e-12);
}

class WholeWalk : public testing::TestWithParam<WalkOptions (*)(double)> {
 protected:
  const std::vector<Reference> walk_ = planned(GetParam()(1));
};
INSTANTIATE_TEST_SUITE_P(, WholeWalk, testing::Values(tangent_circle, perpendicular_circle));

TEST_P(WholeWalk, IsSmoothWithAnUprightWaistAtConstantHeightAndTheCenterOfMassInPlace) {
  expect_smooth(walk_);
  for (std::size_t k = 0; k < walk_.size(); ++k) {
    const Reference& r = walk_[k];
    ASSERT_EQ(r.t_s, static_cast<double>(k) * kPeriod);
    ASSERT_EQ(r.X_PB.linear().col(2), Eigen::Vector3d::UnitZ());
    ASSERT_NEAR(r.X_PB.translation().z(), kRobot.base_height, 1e-15);
    ASSERT_LT((r.X_PB * kRobot.com - r.com).norm(), 1e-14);
  }
}

TEST_P(WholeWalk, StartsHalfSittingAndStandsStillUntilThePreviewSeesAStepAndAtTheEnd) {
  const Reference& start = walk_.front();
  expect_pose(start.X_PB, {0, 0, kRobot.base_height}, 0, 1e-15);
  EXPECT_LT((inverse_kinematics(kRobot, start, kRobot.posture).q - kRobot.posture).cwiseAbs().maxCoeff(),
            1e-12);
  EXPECT_EQ(start.com_velocity.norm(), 0);
  for (const Reference& r : walk_) {
    if (r.t_s > 2.0 - 1.6 - 0.015) break;
    ASSERT_LT((r.com - start.com).norm(), 1e-12) << "at " << r.t_s;  // the gains' rounding, summed up
  }
  EXPECT_LT(walk_.back().com_velocity.norm(), 5e-4);  // 0.19 m · exp(-3.5 · 2 s) · 3.5 / 2 and less
}

TEST_P(WholeWalk, ToTheRightMirrorsTheOneToTheLeft) {
  const auto right = planned(GetParam()(-1));
  ASSERT_EQ(walk_.size(), right.size());
  for (std::size_t k = 0; k < walk_.size() && !HasFailure(); ++k) {
    expect_mirrored(walk_[k].X_PB, right[k].X_PB);
    expect_mirrored(walk_[k].X_PL, right[k].X_PR);
    expect_mirrored(walk_[k].X_PR, right[k].X_PL);
    ASSERT_NEAR(walk_[k].zmp.y(), -right[k].zmp.y(), 1e-10);  // 1e-12 times z_c / g / T²
  }
}

TEST(PatternGenerator, WalksEndWhereTheirCommandsLead) {
  for (const auto& [options, x, y] :
       {std::tuple(tangent_circle(), 1.0, -0.5), {perpendicular_circle(), 0.0, 0.0}}) {
    const Reference end = planned(options).back();
    expect_pose(end.X_PL, {kRobot.sole_ahead + x, y + 0.095, 0}, 0, 1e-12);
    expect_pose(end.X_PR, {kRobot.sole_ahead + x, y - 0.095, 0}, 0, 1e-12);
    expect_pose(end.X_PB, {x, y, kRobot.base_height}, 0, 3e-4);  // the remaining motion while coming to rest
  }
}

TEST(PatternGenerator, AnInventedRobotWalksByItsOwnDimensions) {
  const Robot robot = made_up_robot();
  WalkOptions options = walk_of({Straight{0.4, 0.1}, PerpendicularArc{0.75, 0.4}, TangentArc{0.75, -0.5}});
  options.com_height_m = robot.com_height();
  const auto walk = planned(PatternGenerator(robot, options));
  expect_smooth(walk);
  JointVector q = robot.posture;
  for (const Reference& r : walk) {
    ASSERT_LT((r.X_PB * robot.com - r.com).norm(), 1e-12);
    const BodySolution body = inverse_kinematics(robot, r, q);
    ASSERT_EQ(leg_obstacle(robot, body), std::nullopt) << r.t_s;
    ASSERT_LT((body.q - q).cwiseAbs().maxCoeff(), 0.06) << r.t_s;  // 12 rad/s
    for (const Side side : {Side::left, Side::right}) {
      const Eigen::Isometry3d X_PS = r.X_PB * sole_in_base(robot, side, leg_angles(robot.leg(side), body.q));
      ASSERT_LT((X_PS.matrix() - (side == Side::left ? r.X_PL : r.X_PR).matrix()).norm(), 1e-9) << r.t_s;
    }
    q = body.q;
  }
  const Reference& end = walk.back();
  EXPECT_NEAR((end.X_PL.translation() - end.X_PR.translation()).norm(), robot.foot_spacing, 1e-12);
}

TEST(PatternGenerator, TheRobotStandsAfterTheLastTick) {
  PatternGenerator generator(kRobot, walk_of({Straight{0.15, 0}}));
  Reference last;
  for (std::size_t k = 0; k < generator.ticks(); ++k) last = generator.next();
  for (int i = 0; i < 3; ++i) {
    const Reference after = generator.next();
    EXPECT_TRUE(after.X_PB.matrix() == last.X_PB.matrix());
    EXPECT_EQ(after.t_s, last.t_s);
    EXPECT_TRUE(after.com_velocity.isZero(0) && after.waist_velocity.isZero(0) && after.waist_yaw_rate == 0);
  }
}

TEST(PatternGenerator, StepsOutOfReachAreRefusedWithTheCommandTheLegAndTheKeyThatCausesIt) {
  WalkOptions long_steps = walk_of({Stand{1}, Straight{2, 0}});
  long_steps.step_length_m = 0.4;
  WalkOptions low = walk_of({Stand{0.1}, Steps{{{0, 0.49, 0}, {0, -0.19, 0}, {0, 0.49, 0}, {0, -0.19, 0}}}});
  low.com_height_m = 0.3;
  WalkOptions blind =
      walk_of({Stand{0.1}, Steps{{{0, 0.44, 0}, {0, -0.19, 0}, {0, 0.44, 0}, {0, -0.19, 0}}}});
  blind.preview_s = 0.1;
  const WalkOptions tight = walk_of({Stand{0.1}, TangentArc{0.2, 1.5}});
  const std::vector<std::pair<WalkOptions, std::string>> cases{
      {long_steps, "; the cause is walk.step_length_m 0.4; with 0.15, the legs can follow"},
      {low, "; the cause is walk.com_height_m 0.3; with 0.808[0-9]*, the legs can follow"},
      {blind, "; the cause is walk.preview_s 0.1; with 1.6, the legs can follow"},
      {tight,
       R"(; the cause is walk\.commands\[1\]\.tangent_arc\.radius_m 0.2; with 0.75, the legs can follow)"}};
  for (const auto& [options, cause] : cases)
    EXPECT_THAT([&o = options] { PatternGenerator generator(kRobot, o); },
                testing::ThrowsMessage<std::invalid_argument>(testing::MatchesRegex(
                    R"(walk\.commands\[1\]: at [0-9.]+ s the (left|right) [^;]+)" + cause)));
}

TEST(PatternGenerator, ShorterStepsAreProposedIfTheUsualLengthIsOutOfReachToo) {
  Robot stiff = kRobot;
  const auto complaint = [&]() -> std::string {
    try {
      PatternGenerator generator(stiff, walk_of({Stand{0.1}, Straight{1, 0}}));
      return "";
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
  };
  while (complaint().empty())  // hips that swing ahead less and less
    for (const Leg& leg : stiff.legs) stiff.joints[std::size_t(leg.joints[2])].lowest += 0.02;
  EXPECT_THAT(complaint(), testing::EndsWith("walk.step_length_m 0.15; with 0.1125, the legs can follow"));
}

WalkOptions diagonal_and_quarter() {
  return walk_of({Stand{1}, Straight{0.6, -0.3}, Stand{0.5}, TangentArc{0.75, 60 * kDegree}, Stand{1}});
}

TEST(PatternGenerator, PlansForTheRobotsCenterOfMassHeightUnlessOneIsSet) {
  WalkOptions stated = diagonal_and_quarter();
  stated.com_height_m = kRobot.com_height();
  PatternGenerator plan(kRobot, diagonal_and_quarter()), same(kRobot, stated);
  for (std::size_t k = 0; k < plan.ticks(); ++k) ASSERT_EQ(plan.next().com, same.next().com) << k;
}

std::vector<Footstep> landings_from(const PatternGenerator& plan, std::size_t step) {
  std::vector<Footstep> all;
  for (; step < plan.steps(); ++step) all.push_back(plan.landing(step));
  return all;
}

/// The walk, with change(plan) called whenever a step can be changed for the last time.
std::vector<Reference> changed_walk(const std::function<void(PatternGenerator&)>& change) {
  PatternGenerator plan(kRobot, diagonal_and_quarter());
  std::vector<Reference> walk;
  while (walk.size() < plan.ticks()) {
    if (plan.is_due()) change(plan);
    walk.push_back(plan.next());
  }
  return walk;
}

/// Moves the step that is due, and with it all following steps, by `by` in its own axes.
void move_by(PatternGenerator& plan, const FootPose& by) {
  auto rest = landings_from(plan, plan.free_step());
  const FootPose moved = rest.front().pose * by * inverse(rest.front().pose);
  for (Footstep& step : rest) step.pose = moved * step.pose;
  plan.replan(plan.free_step(), rest);
}

bool same_bits(const Reference& a, const Reference& b) {
  return a.t_s == b.t_s && a.com == b.com && a.com_velocity == b.com_velocity &&
         a.com_acceleration == b.com_acceleration && a.zmp == b.zmp && a.zmp_reference == b.zmp_reference &&
         a.X_PB.matrix() == b.X_PB.matrix() && a.waist_velocity == b.waist_velocity &&
         a.waist_yaw_rate == b.waist_yaw_rate && a.X_PL.matrix() == b.X_PL.matrix() &&
         a.X_PR.matrix() == b.X_PR.matrix() && a.support == b.support && a.command == b.command;
}

TEST(Replanning, TheSameLandingsGiveTheSameBits) {
  const auto plain = planned(diagonal_and_quarter());
  std::size_t times = 0;
  const auto again = changed_walk([&](PatternGenerator& plan) {
    plan.replan(plan.free_step(), landings_from(plan, plan.free_step()));
    ++times;
  });
  EXPECT_EQ(times, PatternGenerator(kRobot, diagonal_and_quarter()).steps());  // each once
  ASSERT_EQ(plain.size(), again.size());
  for (std::size_t k = 0; k < plain.size(); ++k) ASSERT_TRUE(same_bits(plain[k], again[k])) << k;
}

TEST(Replanning, TheWalkBeforeAChangeIsTheOriginalPlanBitForBit) {
  const auto plain = planned(diagonal_and_quarter());
  double changed_s = 0;
  const auto walk = changed_walk([&](PatternGenerator& plan) {
    if (plan.free_step() != 3) return;
    changed_s = static_cast<double>(plan.touch_down(3)) * kPeriod;
    move_by(plan, {{0.03, 0.02}, 3 * kDegree});
  });
  // The change enters the preview at its far end, 1.6 s before the step's landing.
  std::size_t k = 0;
  for (; walk[k].t_s < changed_s - 1.6; ++k) ASSERT_TRUE(same_bits(plain[k], walk[k])) << k;
  for (; k < plain.size() && same_bits(plain[k], walk[k]); ++k) continue;
  EXPECT_LT(walk[k].t_s, changed_s - 1.5);
  EXPECT_GT((plain.back().X_PB.translation() - walk.back().X_PB.translation()).norm(), 0.02);
}

/// The largest changes of ZMP, jerk and feet from tick to tick.
Eigen::Vector3d largest_steps(const std::vector<Reference>& walk) {
  Eigen::Vector3d most = Eigen::Vector3d::Zero();
  for (std::size_t k = 1; k < walk.size(); ++k) {
    const Reference &a = walk[k - 1], &b = walk[k];
    most = most.cwiseMax(Eigen::Vector3d((b.zmp - a.zmp).norm(),
                                         (b.com_acceleration - a.com_acceleration).norm() / kPeriod,
                                         std::max(speed(a.X_PL, b.X_PL), speed(a.X_PR, b.X_PR))));
  }
  return most;
}

TEST(Replanning, AChangedWalkIsAsSmoothAsAPlanThatNeverChanges) {
  const Eigen::Vector3d plain = largest_steps(planned(diagonal_and_quarter()));
  for (const FootPose& by : {FootPose{{0.02, 0}, 0}, FootPose{{-0.02, 0.01}, 0},
                             FootPose{{0, 0.01}, 1 * kDegree}, FootPose{{-0.01, -0.01}, -2 * kDegree}}) {
    int step = 0;
    expect_smooth(changed_walk([&](PatternGenerator& plan) {
      if (step++ % 2 == 0) move_by(plan, by);
    }));
    const Eigen::Vector3d changed = largest_steps(changed_walk([&](PatternGenerator& plan) {
      if (plan.free_step() == 3) move_by(plan, by);
    }));
    // A step that is longer by 20 mm or turned by 2 degrees moves foot and ZMP that much faster.
    EXPECT_TRUE((changed.array() < 1.2 * plain.array()).all()) << changed.transpose();
  }
}

TEST(Replanning, FeetLandWhereLastPlanned) {
  std::vector<std::pair<std::size_t, Footstep>> landed;  // with its tick
  const auto walk = changed_walk([&](PatternGenerator& plan) {
    move_by(plan, {{0.01, 0}, 0});
    landed.emplace_back(plan.touch_down(plan.free_step()), plan.landing(plan.free_step()));
  });
  ASSERT_EQ(landed.size(), PatternGenerator(kRobot, diagonal_and_quarter()).steps());
  for (const auto& [tick, landing] : landed) {
    const Eigen::Isometry3d& X = landing.side == Side::left ? walk[tick].X_PL : walk[tick].X_PR;
    EXPECT_LT((X.translation().head<2>() - landing.pose.position).norm(), 1e-12) << tick;
  }
}

TEST(Replanning, StepsAddedAfterTheLastOneAreWalkedFromAStand) {
  for (const std::size_t standing_ticks : {1, 100, 300}) {
    PatternGenerator plan(kRobot, diagonal_and_quarter());
    std::vector<Reference> walk;
    std::size_t add_at = plan.touch_down(plan.steps() - 1) + standing_ticks;
    while (walk.size() < plan.ticks()) {
      if (walk.size() == add_at) {
        const std::size_t n = plan.steps();
        ASSERT_EQ(plan.free_step(), n);
        plan.replan(n, {plan.landing(n - 2), plan.landing(n - 1)});
      }
      walk.push_back(plan.next());
    }
    expect_smooth(walk);
    EXPECT_GT(walk.size(), planned(diagonal_and_quarter()).size() + 2 * 160);
    EXPECT_LT(walk.back().com_velocity.norm(), 5e-4);
  }
}

TEST(Replanning, AStepOutOfReachIsDetectedAndOneThatThePreviewHasUsedCannotBeChanged) {
  PatternGenerator plan(kRobot, diagonal_and_quarter());
  while (!plan.is_due()) plan.next();
  const auto rest = landings_from(plan, 0);
  auto far = rest;
  for (Footstep& step : far) step.pose.position.x() += 0.5;
  EXPECT_TRUE(plan.can_follow(0, rest));
  EXPECT_FALSE(plan.can_follow(0, far));
  plan.next();
  EXPECT_EQ(plan.free_step(), 1u);
  EXPECT_THROW(plan.replan(0, rest), std::logic_error);
}

TEST(FeasibleStep, NominalStepsAreInsideAndOthersAreNot) {
  const auto outside = [](double x, double y, double yaw) {
    return distance_outside(kRobot, {{1, 2}, 0.5},
                            {Side::left, FootPose{{1, 2}, 0.5} * FootPose{{x, y}, yaw}});
  };
  for (const double x : {-0.15, 0.0, 0.15}) EXPECT_EQ(outside(x, 0.19, 0), 0);
  EXPECT_EQ(outside(0.1, 0.25, 0.2), 0);
  EXPECT_NEAR(outside(0.3, 0.19, 0), 0.06, 1e-9);  // 0.28 less the margin
  EXPECT_EQ(outside(0, 0.15, 0), 0);
  EXPECT_NEAR(outside(0, 0.14, 0), 0.008, 1e-9);  // 2 mm between the soles
  EXPECT_GT(outside(0, 0.40, 0), 0.03);
  EXPECT_GT(outside(0, 0.15, 0.5), 0.01);  // heels
  EXPECT_GT(outside(0, -0.19, 0), 0.18);   // crossed
}

}  // namespace
}  // namespace walking
