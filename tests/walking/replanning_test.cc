// Footsteps that change while the plan is being walked.
#include <functional>

#include "tests/walking/walks.h"

namespace walking {
namespace {

WalkOptions diagonal_and_quarter() {
  return walk_of({Stand{1}, Straight{0.6, -0.3}, Stand{0.5}, TangentArc{0.75, 60 * kDegree}, Stand{1}});
}

std::vector<Footstep> landings_from(const PatternGenerator& plan, std::size_t step) {
  std::vector<Footstep> all;
  for (; step < plan.steps(); ++step) all.push_back(plan.landing(step));
  return all;
}

/// The walk, with change(plan) called whenever a step can be changed for the last time.
std::vector<Reference> changed_walk(const std::function<void(PatternGenerator&)>& change) {
  PatternGenerator plan(diagonal_and_quarter());
  std::vector<Reference> walk;
  while (walk.size() < plan.ticks()) {
    if (plan.is_due()) change(plan);
    walk.push_back(plan.next());
  }
  return walk;
}

/// Moves the step that is due, and with it all that follow, by `by` in its own axes.
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
  EXPECT_EQ(times, PatternGenerator(diagonal_and_quarter()).steps());  // each once
  ASSERT_EQ(plain.size(), again.size());
  for (std::size_t k = 0; k < plain.size(); ++k) ASSERT_TRUE(same_bits(plain[k], again[k])) << k;
}

TEST(Replanning, WhatWasWalkedBeforeAChangeIsThePlainPlanBitForBit) {
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

/// The largest steps of ZMP, jerk and feet from tick to tick.
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

TEST(Replanning, FeetLandWhereTheyWereLastPlanned) {
  std::vector<std::pair<std::size_t, Footstep>> landed;  // with its tick
  const auto walk = changed_walk([&](PatternGenerator& plan) {
    move_by(plan, {{0.01, 0}, 0});
    landed.emplace_back(plan.touch_down(plan.free_step()), plan.landing(plan.free_step()));
  });
  ASSERT_EQ(landed.size(), PatternGenerator(diagonal_and_quarter()).steps());
  for (const auto& [tick, landing] : landed) {
    const Eigen::Isometry3d& X = landing.side == Side::left ? walk[tick].X_PL : walk[tick].X_PR;
    EXPECT_LT((X.translation().head<2>() - landing.pose.position).norm(), 1e-12) << tick;
  }
}

TEST(Replanning, AStepThatThePreviewHasUsedCannotBeChanged) {
  PatternGenerator plan(diagonal_and_quarter());
  while (!plan.is_due()) plan.next();
  const auto rest = landings_from(plan, 0);
  plan.next();
  EXPECT_EQ(plan.free_step(), 1u);
  EXPECT_THROW(plan.replan(0, rest), std::logic_error);
}

TEST(Replanning, StepsAddedAfterTheLastOneAreWalkedFromStanding) {
  for (const std::size_t standing_ticks : {1, 100, 300}) {
    PatternGenerator plan(diagonal_and_quarter());
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

TEST(Replanning, AStepBeyondTheLegsIsFound) {
  PatternGenerator plan(diagonal_and_quarter());
  while (!plan.is_due()) plan.next();
  auto rest = landings_from(plan, 0);
  EXPECT_TRUE(plan.can_follow(0, rest));
  for (Footstep& step : rest) step.pose.position.x() += 0.5;
  EXPECT_FALSE(plan.can_follow(0, rest));
}

TEST(FeasibleStep, NominalStepsAreInsideAndOthersAreNot) {
  const auto outside = [](double x, double y, double yaw) {
    return distance_outside({{1, 2}, 0.5}, {Side::left, FootPose{{1, 2}, 0.5} * FootPose{{x, y}, yaw}});
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
