#include "walking/pattern_generator.h"

#include <gmock/gmock.h>

#include "tests/walking/walks.h"
#include "walking/kinematics.h"

namespace walking {
namespace {

constexpr double kPi = std::numbers::pi;

/// The paper's first experiment; turn = +1: diagonal to the right, four quarters to the left; -1: mirrored.
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

TEST_P(WholeWalk, IsSmoothWithTheWaistUprightAtItsHeightAndTheCenterOfMassAtItsPlace) {
  expect_smooth(walk_);
  for (std::size_t k = 0; k < walk_.size(); ++k) {
    const Reference& r = walk_[k];
    ASSERT_EQ(r.t_s, static_cast<double>(k) * kPeriod);
    ASSERT_EQ(r.X_PB.linear().col(2), Eigen::Vector3d::UnitZ());
    ASSERT_NEAR(r.X_PB.translation().z(), hrp2::kWaistHeight, 1e-15);
    ASSERT_LT((r.X_PB * hrp2::kComInWaist - r.com).norm(), 1e-14);
  }
}

TEST_P(WholeWalk, StartsInHalfSittingAndStandsStillUntilThePreviewSeesTheFirstStepAndAtItsEnd) {
  const Reference& start = walk_.front();
  expect_pose(start.X_PB, {0, 0, hrp2::kWaistHeight}, 0, 1e-15);
  EXPECT_LT((inverse_kinematics(posture_of(start)).q - hrp2::half_sitting()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(start.com_velocity.norm(), 0);
  for (const Reference& r : walk_) {
    if (r.t_s > 2.0 - 1.6 - 0.015) break;
    ASSERT_LT((r.com - start.com).norm(), 1e-12) << "at " << r.t_s;  // the gains' rounding, summed up
  }
  EXPECT_LT(walk_.back().com_velocity.norm(), 5e-4);  // 0.19 m · exp(-3.5 · 2 s) · 3.5 / 2 and less
}

TEST_P(WholeWalk, ToTheRightIsTheMirrorImageOfThatToTheLeft) {
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
    expect_pose(end.X_PL, {hrp2::kAnkleX + x, y + 0.095, 0}, 0, 1e-12);
    expect_pose(end.X_PR, {hrp2::kAnkleX + x, y - 0.095, 0}, 0, 1e-12);
    expect_pose(end.X_PB, {x, y, hrp2::kWaistHeight}, 0, 3e-4);  // what is left of coming to rest
  }
}

TEST(PatternGenerator, AfterTheLastTickTheRobotStands) {
  PatternGenerator generator(walk_of({Straight{0.15, 0}}));
  Reference last;
  for (std::size_t k = 0; k < generator.ticks(); ++k) last = generator.next();
  for (int i = 0; i < 3; ++i) {
    const Reference after = generator.next();
    EXPECT_TRUE(after.X_PB.matrix() == last.X_PB.matrix());
    EXPECT_EQ(after.t_s, last.t_s);
    EXPECT_TRUE(after.com_velocity.isZero(0) && after.waist_velocity.isZero(0) && after.waist_yaw_rate == 0);
  }
}

TEST(PatternGenerator, StepsBeyondTheLegsAreRefusedWithTheCommandTheLegAndAKeyThatIsTheCause) {
  WalkOptions long_steps = walk_of({Stand{1}, Straight{2, 0}});
  long_steps.step_length_m = 0.4;
  WalkOptions low = walk_of({Stand{0.1}, Steps{{{0, 0.49, 0}, {0, -0.19, 0}, {0, 0.49, 0}, {0, -0.19, 0}}}});
  low.com_height_m = 0.3;
  WalkOptions blind =
      walk_of({Stand{0.1}, Steps{{{0, 0.44, 0}, {0, -0.19, 0}, {0, 0.44, 0}, {0, -0.19, 0}}}});
  blind.preview_s = 0.1;
  const WalkOptions tight = walk_of({Stand{0.1}, TangentArc{0.2, 1.5}});
  const std::vector<std::pair<WalkOptions, std::string>> cases{
      {long_steps, "; the cause is walk.step_length_m 0.4, with 0.15 the legs can follow"},
      {low, "; the cause is walk.com_height_m 0.3, with 0.814 the legs can follow"},
      {blind, "; the cause is walk.preview_s 0.1, with 1.6 the legs can follow"},
      {tight,
       R"(; the cause is walk\.commands\[1\]\.tangent_arc\.radius_m 0.2, with 0.75 the legs can follow)"}};
  for (const auto& [options, cause] : cases)
    EXPECT_THAT([&o = options] { PatternGenerator generator(o); },
                testing::ThrowsMessage<std::invalid_argument>(testing::MatchesRegex(
                    R"(walk\.commands\[1\]: at [0-9.]+ s the (left|right) [^;]+)" + cause)));
}

}  // namespace
}  // namespace walking
