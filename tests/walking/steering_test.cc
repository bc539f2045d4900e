#include "walking/steering.h"

#include "tests/walking/walks.h"

namespace walking {
namespace {

WalkOptions straight() { return walk_of({Stand{1}, Straight{1.5, 0}, Stand{1}}); }

SteeringOptions eager() {
  SteeringOptions options;
  options.by = SteeredBy::estimate;
  options.gain = 1;
  return options;
}

/// The pose of the plan's world in W at a time.
using Drift = std::function<FootPose(double t_s)>;
FootPose none(double) { return {}; }

/// A walk steered by an estimate that knows the drift until some time, with a latency of 0.1 s.
struct SteeredWalk {
  SteeredWalk(const SteeringOptions& options, const Drift& drift, double known_until_s = 1e9,
              const Eigen::Matrix3d& covariance = Eigen::Matrix3d::Zero())
      : plan(kRobot, straight()), steering(options, plan) {
    std::optional<PlaceEstimate> newest;
    for (std::size_t tick = 0; tick < plan.ticks(); ++tick) {
      const double t_s = static_cast<double>(tick) * kPeriod - 0.1;
      if (t_s > 0 && t_s < known_until_s) {
        const Eigen::Isometry3d& X_PL = walk[walk.size() - 20].X_PL;
        const FootPose planned{X_PL.translation().head<2>(), 0};
        newest = PlaceEstimate{t_s, planned, drift(t_s) * planned, covariance};
      }
      if (steering.is_due(plan, tick)) steering.decide(plan, tick, newest);
      walk.push_back(plan.next());
    }
  }

  FootPose end_in_world(const Drift& drift) const {
    const Reference& r = walk.back();
    const FootPose left{r.X_PL.translation().head<2>(), yaw_of(r.X_PL)},
        right{r.X_PR.translation().head<2>(), yaw_of(r.X_PR)};
    return drift(r.t_s) * center_of({left, right});
  }

  PatternGenerator plan;
  Steering steering;
  std::vector<Reference> walk;
};

void expect_within_limits(const SteeredWalk& steered, const SteeringOptions& options) {
  for (const StepCorrection& c : steered.steering.corrections()) {
    EXPECT_LE(std::abs(c.correction.position.x()), options.largest_ahead_m) << c.step;
    EXPECT_LE(std::abs(c.correction.position.y()), options.largest_aside_m) << c.step;
    EXPECT_LE(std::abs(c.correction.yaw), options.largest_turn_rad) << c.step;
  }
  for (const Reference& r : steered.walk)
    ASSERT_FALSE(leg_obstacle(kRobot, inverse_kinematics(kRobot, r, kRobot.posture))) << "at " << r.t_s;
  for (std::size_t k = 0; k < steered.plan.steps(); ++k) {
    const Footstep landing = steered.plan.landing(k);
    EXPECT_EQ(distance_outside(kRobot, steered.plan.stance_before(k).of(other(landing.side)), landing), 0)
        << k;
  }
}

TEST(Steering, ThePlaceByLegsIsTheSoleThatCarriesWithTheDriftOfTheOdometry) {
  const FootPose drift{{0.3, -0.2}, 0.1};
  Reference at = planned(straight())[400];
  ASSERT_NE(at.support, Support::both);
  Eigen::Isometry3d X_OB = sole(drift) * at.X_PB;
  const Eigen::Isometry3d& X_PS = at.support == Support::left ? at.X_PL : at.X_PR;
  const PlaceEstimate place = place_by_legs(X_OB, at, true);
  EXPECT_EQ(place.t_s, at.t_s);
  EXPECT_LT((place.planned.position - X_PS.translation().head<2>()).norm(), 1e-12);
  EXPECT_LT((place.estimated.position - (drift * on_floor(X_PS)).position).norm(), 1e-12);
  EXPECT_NEAR(place.estimated.yaw - place.planned.yaw, drift.yaw, 1e-12);
  EXPECT_LT((place_by_legs(X_OB, at, false).estimated.position - X_OB.translation().head<2>()).norm(), 1e-12);

  for (Eigen::Isometry3d* X : {&at.X_PB, &at.X_PL, &at.X_PR}) X->pretranslate(Eigen::Vector3d(0.01, 0.02, 0));
  at.frame_shift = {0.01, 0.02};
  EXPECT_LT((place_by_legs(X_OB, at, true).planned.position - place.planned.position).norm(), 1e-12)
      << "adjusted landings are no part of the path";
}

TEST(Steering, WithoutAnErrorThePlanIsUnchangedBitForBit) {
  const SteeredWalk steered(eager(), none);
  const auto plain = planned(straight());
  ASSERT_EQ(steered.walk.size(), plain.size());
  for (std::size_t k = 0; k < plain.size(); ++k) {
    // Corrections of zero are composed with the path, which causes rounding.
    ASSERT_LT((steered.walk[k].X_PB.matrix() - plain[k].X_PB.matrix()).norm(), 1e-9) << k;
  }
}

// The plan drifts while the robot walks, as it does when soles slip, but no longer once it has arrived.
TEST(Steering, EndsWithinTheToleranceOfItsGoalAlthoughThePlanDrifts) {
  const Drift drift = [](double t_s) {
    const double t = std::min(t_s, 10.0);
    return FootPose{{0.004 * t, 0.005 * t}, 0.2 * kDegree * t};
  };
  const SteeringOptions options = eager().with_tolerance();
  const SteeredWalk steered(options, drift);
  const FootPose end = steered.end_in_world(drift), goal{{1.5 + kRobot.sole_ahead, 0}, 0};
  EXPECT_LT((end.position - goal.position).norm(), options.tolerance_m + 1e-9);
  EXPECT_LT(std::abs(end.yaw), options.tolerance_rad + 1e-9);
  expect_within_limits(steered, options);
  expect_smooth(steered.walk);
  const auto plain = planned(straight());
  EXPECT_GT(((drift(plain.back().t_s) * goal).position - goal.position).norm(), 0.08);
}

TEST(Steering, AJumpOfTheEstimateIsAbsorbedInLimitedSteps) {
  for (const FootPose& jump :
       {FootPose{{0.3, 0}, 0}, FootPose{{0, -0.3}, 0}, FootPose{{0, 0}, 10 * kDegree}}) {
    const SteeredWalk steered(eager(), [&](double t) { return t < 4 ? FootPose{} : jump; });
    expect_within_limits(steered, eager());
    expect_smooth(steered.walk);
  }
}

TEST(Steering, StepsAreCorrectedStartingAtTheFirstDecisionAfterTheEstimate) {
  const SteeredWalk steered(eager(), [](double t) { return t < 4 ? FootPose{} : FootPose{{0.01, 0}, 0}; });
  const auto& all = steered.steering.corrections();
  const auto first = std::find_if(all.begin(), all.end(), [](const auto& c) { return c.decided_s >= 4.1; });
  for (auto before = all.begin(); before != first; ++before)
    EXPECT_EQ(before->correction.position.norm(), 0) << before->decided_s;
  ASSERT_NE(first, all.end());
  EXPECT_NEAR(first->correction.position.x(), -0.01, 1e-9);  // the whole error at gain 1
  const double landed_s = static_cast<double>(steered.plan.touch_down(first->step)) * kPeriod;
  EXPECT_NEAR(landed_s - first->decided_s, 1.6, 0.02);
}

TEST(Steering, ErrorsWithinTheDeadBandAreNotCorrected) {
  SteeringOptions options = eager();
  options.dead_band_sigma = 1;
  const Eigen::Matrix3d covariance = Eigen::Vector3d(0.005 * 0.005, 0.005 * 0.005, 0).asDiagonal();
  const auto drift = [](double) { return FootPose{{0.004, 0.009}, 0}; };
  const SteeredWalk steered(options, drift, 1e9, covariance);
  for (const StepCorrection& c : steered.steering.corrections()) EXPECT_EQ(c.correction.position.x(), 0);
  EXPECT_NEAR(steered.steering.corrections().at(0).correction.position.y(), -0.004, 1e-9);
}

TEST(Steering, StopsOnBothFeetOrContinuesWithThePlanWhenTheEstimateStaysLost) {
  SteeringOptions options = eager();
  options.lost_s = 2;
  const SteeredWalk steered(options, none, 4);
  ASSERT_TRUE(steered.steering.stopped_s());
  EXPECT_GT(*steered.steering.stopped_s(), 5.9);
  EXPECT_LT(*steered.steering.stopped_s(), 5.9 + 0.9);  // at the next step
  EXPECT_LT(steered.walk.size(), planned(straight()).size());
  const Reference& end = steered.walk.back();
  EXPECT_NEAR((end.X_PL.translation() - end.X_PR.translation()).norm(), 0.19, 1e-9);
  expect_smooth(steered.walk);
  options.on_lost = OnLost::go_on;
  const SteeredWalk going_on(options, none, 4);
  EXPECT_FALSE(going_on.steering.stopped_s());
  EXPECT_EQ(going_on.walk.size(), planned(straight()).size());
}

TEST(Steering, AddsNoMoreStepsAtTheEndThanAllowed) {
  SteeringOptions options = eager();
  for (const int most : {0, 3, 8}) {
    options.final_steps = most;
    // An error that no step can correct, because the drift undoes each correction.
    const SteeredWalk steered(options, [](double t) { return FootPose{{0.05 * t, 0}, 0}; });
    EXPECT_EQ(steered.plan.steps(),
              PatternGenerator(kRobot, straight()).steps() + static_cast<std::size_t>(most / 2 * 2));
  }
}

}  // namespace
}  // namespace walking
