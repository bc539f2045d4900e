#include "walking/footsteps.h"

#include "tests/walking/walks.h"

namespace walking {
namespace {

constexpr double kExact = 1e-12;         // rounding of a few rotations
constexpr double kSixDecimals = 1.1e-6;  // reference values have six decimals, degrees four

void expect_foot(const Footstep& step, Side side, double x, double y, double degrees) {
  EXPECT_EQ(step.side, side);
  EXPECT_NEAR(step.pose.position.x(), x, kSixDecimals);
  EXPECT_NEAR(step.pose.position.y(), y, kSixDecimals);
  EXPECT_NEAR(step.pose.yaw / kDegree, degrees, 6e-5);
}

/// A landing in the form of the step stack: relative to the previous foot, in axes that are first turned to
/// the new heading.
void expect_relative(const FootPose& before, const FootPose& now, double dx, double dy, double degrees) {
  const Eigen::Vector2d d = Eigen::Rotation2Dd(-now.yaw) * (now.position - before.position);
  EXPECT_NEAR(d.x(), dx, kSixDecimals);
  EXPECT_NEAR(d.y(), dy, kSixDecimals);
  EXPECT_NEAR((now.yaw - before.yaw) / kDegree, degrees, kSixDecimals);
}

void expect_ends_together_at(const std::vector<Footstep>& steps, const FootPose& center) {
  const Stance end = feet_together(center, kRobot.foot_spacing);
  ASSERT_GE(steps.size(), 2u);
  for (const Footstep& step : {steps[steps.size() - 2], steps.back()}) {
    EXPECT_LT((step.pose.position - end.of(step.side).position).norm(), kExact);
    EXPECT_NEAR(step.pose.yaw, center.yaw, kExact);
  }
  EXPECT_NE(steps.back().side, steps[steps.size() - 2].side);
}

TEST(TangentArc, QuarterCircleMatchesTheReferenceStepStack) {
  const auto steps = footsteps(kRobot, TangentArc{0.75, 90 * kDegree}, {}, 0.15);
  ASSERT_EQ(steps.size(), 9u);  // seven whole steps, the remainder, the closing step
  expect_foot(steps[0], Side::right, .167876, -.078156, 11.4592);
  expect_foot(steps[1], Side::left, .255069, .146705, 22.9183);
  expect_foot(steps[2], Side::right, .477123, .052591, 34.3775);
  expect_relative(steps[5].pose, steps[6].pose, .130128, -.203056, 11.459156);
  expect_relative(steps[6].pose, steps[7].pose, .143622, .177705, 9.785909);
  expect_foot(steps[7], Side::left, .655, .750, 90);
  expect_foot(steps[8], Side::right, .845, .750, 90);
}

TEST(PerpendicularArc, FullCircleMatchesTheReferenceStepStack) {
  const auto steps = footsteps(kRobot, PerpendicularArc{0.75, 360 * kDegree}, {}, 0.10);
  ASSERT_EQ(steps.size(), 96u);  // 97 entries of the stack; the first only names the first support
  expect_relative({{0, .095}, 0}, steps[0].pose, -.019286, -.288861, 7.639437);
  expect_relative(steps[0].pose, steps[1].pose, 0, .19, 0);
  expect_relative(steps[93].pose, steps[94].pose, -.001672, -.202375, .946448);
  expect_foot(steps[22], Side::right, .866859, -.746906, 91.6732);
  expect_foot(steps[46], Side::right, 1.493176, .138619, 183.3465);
  expect_foot(steps[70], Side::right, .589740, .738811, 275.0197);
  expect_ends_together_at(steps, {{0, 0}, 360 * kDegree});
}

TEST(Straight, DiagonalAssignsTheLateralShareToTheFootOnThatSide) {
  const auto steps = footsteps(kRobot, Straight{1.0, -0.5}, {}, 0.15);
  ASSERT_EQ(steps.size(), 9u);  // 1.118 m: seven whole steps, the remainder, the closing step
  const double forward = 0.15 * 1.0 / std::hypot(1.0, 0.5), aside = -forward / 2;
  EXPECT_EQ(steps[0].side, Side::right);
  for (int k = 0; k < 7; ++k) EXPECT_NEAR(steps[k].pose.position.x(), (k + 1) * forward, kExact);
  double left = 0.095;
  for (int k = 0; k + 2 < 8; k += 2) {
    EXPECT_NEAR(left - steps[k].pose.position.y(), 0.19 - 2 * aside, kExact);
    left = steps[k + 1].pose.position.y();
    EXPECT_NEAR(left - steps[k].pose.position.y(), 0.19, kExact);
  }
}

TEST(Straight, FeetAreNeverCloserSidewaysThanTheirSpacingNorSetFurtherAsideThanTheRobotCanStand) {
  for (const Straight& way :
       {Straight{1.3, -0.7}, Straight{1.3, 0}, Straight{1.3, 0.13}, Straight{0, 2.5}, Straight{0.2, -1.3}}) {
    Stance stance = feet_together({}, kRobot.foot_spacing);
    for (const Footstep& step : footsteps(kRobot, way, {}, 0.4)) {
      EXPECT_LE(std::abs(step.pose.position.y() - stance.of(step.side).position.y()), 0.14 + kExact);
      stance.of(step.side) = step.pose;
      EXPECT_GE(stance.left.position.y() - stance.right.position.y(), kRobot.foot_spacing - kExact);
    }
  }
}

TEST(Footsteps, HaveTheNumberSetByStepLengthAndArcKeyPlusOneForARemainder) {
  for (const auto& [command, step_length_m, count] :
       {std::tuple<Command, double, std::size_t>{PerpendicularArc{1, 0.6}, 0.4, 10},
        {PerpendicularArc{1, 0.6, 0.15}, 0.4, 8},
        {PerpendicularArc{1, 0.6}, 0.1, 12},
        {Straight{0.45, 0}, 0.15, 4},  // 0.45 / 0.15 is just below 3 in binary
        {Straight{0.46, 0}, 0.15, 5},
        {Steps{{{0, 0.29, 0}, {0, -0.19, 0}}}, 0.15, 2},  // together already
        {GoTo{-kRobot.sole_ahead, 0, 0}, 0.15, 0}})       // the present place
    EXPECT_EQ(footsteps(kRobot, command, {}, step_length_m).size(), count);
}

TEST(Footsteps, EveryCommandEndsWithFeetTogetherAtItsNominalPlaceWhereverItStarts) {
  const FootPose start{{3, -2}, 2.5};
  const std::vector<std::pair<Command, FootPose>> cases{
      {Straight{1, 0.5}, {{1, 0.5}, 0}},
      {Straight{0.9, -0.2}, {{0.9, -0.2}, 0}},
      {Straight{-0.4, 0}, {{-0.4, 0}, 0}},
      {Straight{0, 2.5}, {{0, 2.5}, 0}},
      {Steps{{{0, 0.29, 0}, {0, -0.19, 0}}}, {{0, 0.1}, 0}},
      {TangentArc{0.75, 1.3}, {{0.75 * std::sin(1.3), 0.75 * (1 - std::cos(1.3))}, 1.3}},
      {TangentArc{0.75, -1.3}, {{0.75 * std::sin(1.3), -0.75 * (1 - std::cos(1.3))}, -1.3}},
      {PerpendicularArc{0.75, 1.3}, {{0.75 * (1 - std::cos(1.3)), -0.75 * std::sin(1.3)}, 1.3}}};
  for (const auto& [command, end] : cases)
    expect_ends_together_at(footsteps(kRobot, command, start, 0.15), start * end);
}

TEST(Steps, TheFrameIsTurnedBeforeTheFootIsSetDownInIt) {
  const auto steps = footsteps(kRobot, Steps{{{0.1, -0.2, 90 * kDegree}}}, {}, 0.15);
  ASSERT_EQ(steps.size(), 2u);
  expect_foot(steps[0], Side::right, 0.2, 0.195, 90);  // from the left foot at (0, 0.095): 0.1 along y
  expect_foot(steps[1], Side::left, 0.01, 0.195, 90);  // and the feet are brought together
}

TEST(Footsteps, InfeasibleCommandsAreRefusedAndStepsAreNamedByTheirNumber) {
  for (const auto& [command, words] : {std::pair<Command, const char*>{Straight{0, 0}, ""},
                                       {TangentArc{0.75, 0}, ""},
                                       {Steps{}, ""},
                                       {Steps{{{0, 0.19, 0}, {0, 0.19, 0}}}, "step 2"},
                                       {Steps{{{0, 0.19, 0}, {0, 0, 0}}}, "step 2"}})
    EXPECT_THAT([&c = command] { footsteps(kRobot, c, {}, 0.15); },
                testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr(words)));
}

TEST(Turn, FeetTurnOnTheSpotAndEndTogether) {
  for (const double angle : {90.0, -45.0, 7.0, 200.0}) {
    const auto steps = footsteps(kRobot, Turn{angle * kDegree, 10 * kDegree}, {{1, 2}, 0.3}, 0.15);
    EXPECT_EQ(steps.size(), static_cast<std::size_t>(std::ceil(std::abs(angle) / 10)) + 1);
    EXPECT_EQ(steps.front().side, angle > 0 ? Side::left : Side::right);
    expect_ends_together_at(steps, {{1, 2}, 0.3 + angle * kDegree});
    for (const Footstep& step : steps)
      EXPECT_NEAR((step.pose.position - Eigen::Vector2d(1, 2)).norm(), kRobot.foot_spacing / 2, kExact);
  }
}

/// The feet together below a waist at that place.
FootPose feet_below(double x, double y, double degrees) {
  return FootPose{{x, y}, degrees * kDegree} * FootPose{{kRobot.sole_ahead, 0}, 0};
}

TEST(GoTo, EndsUnderTheWaistAtItsPlaceWhereverItBegins) {
  for (const FootPose& start :
       {FootPose{{kRobot.sole_ahead, 0}, 0}, FootPose{{-1, 2}, 2.5}, FootPose{{0, 0}, 9}}) {
    const auto steps = footsteps(kRobot, GoTo{0.5, -0.8, 120 * kDegree}, start, 0.15);
    FootPose goal = feet_below(0.5, -0.8, 120);
    goal.yaw = steps.back().pose.yaw;  // up to whole turns
    EXPECT_NEAR(std::remainder(goal.yaw - 120 * kDegree, 2 * std::numbers::pi), 0, kExact);
    expect_ends_together_at(steps, goal);
  }
}

TEST(GoTo, TurnsFirstAndWalksAhead) {
  const auto steps = footsteps(kRobot, GoTo{0, 1, 0}, feet_below(0, 0, 0), 0.15);
  // A turn on the spot by about 90 degrees, then straight toward the goal.
  const Eigen::Vector2d begin(kRobot.sole_ahead, 0);
  std::size_t turning = 0;
  while ((steps[turning].pose.position - begin).norm() < 0.096) ++turning;
  EXPECT_EQ(turning, 9u + 1);
  for (std::size_t k = turning; k < turning + 3; ++k) EXPECT_NEAR(steps[k].pose.yaw, 90 * kDegree, 1e-9);
}

}  // namespace
}  // namespace walking
