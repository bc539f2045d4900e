#include "walking/pattern_generator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/walking/smooth_walk.h"
#include "walking/hrp2.h"
#include "walking/kinematics.h"
#include "walking/plan_cause.h"

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

void expect_pose(const Eigen::Isometry3d& X, double x, double y, double z, double yaw, double tolerance) {
  EXPECT_LT((X.translation() - Eigen::Vector3d(x, y, z)).norm(), tolerance);
  EXPECT_NEAR(std::remainder(yaw_of(X) - yaw, 2 * kPi), 0, tolerance);
}

struct NamedWalk {
  const char* name;
  WalkOptions options;
};
void PrintTo(const NamedWalk& walk, std::ostream* out) { *out << walk.name; }

class WholeWalk : public ::testing::TestWithParam<NamedWalk> {
 protected:
  const std::vector<Reference> walk_ = planned(GetParam().options);
};
INSTANTIATE_TEST_SUITE_P(, WholeWalk,
                         ::testing::Values(NamedWalk{"TangentLeft", tangent_circle(1)},
                                           NamedWalk{"TangentRight", tangent_circle(-1)},
                                           NamedWalk{"PerpendicularLeft", perpendicular_circle(1)},
                                           NamedWalk{"PerpendicularRight", perpendicular_circle(-1)}),
                         [](const auto& test) { return test.param.name; });

TEST_P(WholeWalk, IsTimedEveryFiveMilliseconds) {
  for (std::size_t k = 0; k < walk_.size(); ++k) ASSERT_EQ(walk_[k].t_s, static_cast<double>(k) * kPeriod);
}

TEST_P(WholeWalk, WaistStaysUprightAtItsHeightWithTheCenterOfMassAtItsPlace) {
  for (const Reference& r : walk_) {
    ASSERT_EQ(r.X_PB.linear().col(2), Eigen::Vector3d::UnitZ());
    ASSERT_NEAR(r.X_PB.translation().z(), hrp2::kWaistHeight, 1e-15);
    ASSERT_LT((r.X_PB * hrp2::kComInWaist - r.com).norm(), 1e-14);
  }
}

TEST_P(WholeWalk, IsSmooth) { expect_smooth(walk_); }

TEST_P(WholeWalk, StartsInHalfSittingAtRest) {
  const Reference& r = walk_.front();
  expect_pose(r.X_PB, 0, 0, hrp2::kWaistHeight, 0, 1e-15);
  EXPECT_LT((inverse_kinematics(posture_of(r)).q - hrp2::half_sitting()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(r.com_velocity.norm(), 0);
}

TEST_P(WholeWalk, StandsStillUntilThePreviewSeesTheFirstStep) {
  for (const Reference& r : walk_) {
    if (r.t_s > 2.0 - 1.6 - 0.015) break;
    ASSERT_LT((r.com - walk_.front().com).norm(), 1e-12) << "at " << r.t_s;  // the gains' rounding, summed up
  }
}

TEST_P(WholeWalk, ComesToRestAtItsEnd) {
  EXPECT_LT(walk_.back().com_velocity.norm(), 5e-4);  // 0.19 m · exp(-3.5 · 2 s) · 3.5 / 2 and less
}

TEST(TangentCircle, EveryCommandEndsAtItsNominalPlace) {
  const WalkOptions options = tangent_circle();
  PatternGenerator generator(options);
  Reference before = generator.next();
  // Center of the feet and heading after each command.
  const double x[] = {0, 1, 1, 1.75, 1.75, 1, 1, .25, .25, 1, 1};
  const double y[] = {0, -.5, -.5, .25, .25, 1, 1, .25, .25, -.5, -.5};
  const double quarters[] = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4};
  const auto expect_together = [&](int command, const Reference& r) {
    const double yaw = quarters[command] * kPi / 2;
    const Eigen::Vector2d left = 0.095 * Eigen::Vector2d(-std::sin(yaw), std::cos(yaw));
    // The circle goes through the feet's center, which starts kAnkleX ahead of P's origin.
    expect_pose(r.X_PL, hrp2::kAnkleX + x[command] + left.x(), y[command] + left.y(), 0, yaw, 1e-12);
    expect_pose(r.X_PR, hrp2::kAnkleX + x[command] - left.x(), y[command] - left.y(), 0, yaw, 1e-12);
  };
  for (std::size_t k = 1; k < generator.ticks(); ++k) {
    const Reference now = generator.next();
    if (now.command != before.command && std::holds_alternative<Stand>(options.commands[now.command])) {
      expect_together(before.command, now);
    }
    before = now;
  }
  expect_together(10, before);
  expect_pose(before.X_PB, 1, -0.5, hrp2::kWaistHeight, 0, 3e-4);  // what is left of coming to rest
}

TEST(PerpendicularCircle, ReturnsToItsStart) {
  const Reference end = planned(perpendicular_circle()).back();
  expect_pose(end.X_PL, hrp2::kAnkleX, 0.095, 0, 0, 1e-12);
  expect_pose(end.X_PR, hrp2::kAnkleX, -0.095, 0, 0, 1e-12);
}

void expect_mirrored(const Eigen::Isometry3d& one, const Eigen::Isometry3d& two) {
  const Eigen::Vector3d mirrored(two.translation().x(), -two.translation().y(), two.translation().z());
  ASSERT_LT((one.translation() - mirrored).norm(), 1e-12);  // rounding
  ASSERT_NEAR(std::remainder(yaw_of(one) + yaw_of(two), 2 * kPi), 0, 1e-12);
}

TEST(PatternGenerator, LeftAndRightCirclesAreMirrorImages) {
  for (const auto circle : {tangent_circle, perpendicular_circle}) {
    const auto left = planned(circle(1)), right = planned(circle(-1));
    ASSERT_EQ(left.size(), right.size());
    for (std::size_t k = 0; k < left.size(); ++k) {
      expect_mirrored(left[k].X_PB, right[k].X_PB);
      expect_mirrored(left[k].X_PL, right[k].X_PR);
      expect_mirrored(left[k].X_PR, right[k].X_PL);
      ASSERT_NEAR(left[k].zmp.y(), -right[k].zmp.y(), 1e-10);  // 1e-12 times z_c / g / T²
    }
  }
}

TEST(PatternGenerator, AfterTheLastTickTheRobotStands) {
  WalkOptions options;
  options.commands = {Straight{0.15, 0}};
  PatternGenerator generator(options);
  Reference last;
  for (std::size_t k = 0; k < generator.ticks(); ++k) last = generator.next();
  for (int i = 0; i < 3; ++i) {
    const Reference after = generator.next();
    EXPECT_TRUE(after.X_PB.matrix() == last.X_PB.matrix());
    EXPECT_EQ(after.t_s, last.t_s);
    EXPECT_TRUE(after.com_velocity.isZero(0) && after.waist_velocity.isZero(0) && after.waist_yaw_rate == 0);
  }
}

TEST(PatternGenerator, SameOptionsGiveTheSameBits) {
  const auto one = planned(tangent_circle()), two = planned(tangent_circle());
  for (std::size_t k = 0; k < one.size(); ++k) {
    ASSERT_TRUE(one[k].X_PB.matrix() == two[k].X_PB.matrix());
    ASSERT_TRUE(one[k].zmp == two[k].zmp);
  }
}

TEST(PatternGenerator, StepsBeyondTheLegsAreRefusedSayingWhichLegAndWhen) {
  WalkOptions options;
  options.step_length_m = 0.4;
  options.commands = {Stand{1}, Straight{2, 0}};
  try {
    PatternGenerator generator(options);
    FAIL() << "a stride of 0.8 m was accepted";
  } catch (const std::invalid_argument& e) {
    const std::string said = e.what();
    EXPECT_NE(said.find("walk.commands[1]"), std::string::npos) << said;
    EXPECT_NE(said.find("walk.step_length_m"), std::string::npos) << said;
  }
}

using testing::EndsWith;
using testing::HasSubstr;

std::string refusal_of(const WalkOptions& options) {
  try {
    PatternGenerator generator(options);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

WalkOptions walk_of(const Command& command) {
  WalkOptions options;
  options.commands = {Stand{0.1}, command};
  return options;
}

TEST(PlanCause, IsTheLengthOfTheStepsWhereThatIsTooLong) {
  WalkOptions options = walk_of(Straight{2, 0});
  options.step_length_m = 0.4;
  EXPECT_THAT(refusal_of(options),
              EndsWith("the cause is walk.step_length_m 0.4, with 0.15 the legs can follow"));
}

TEST(PlanCause, IsTheKeyOfTheWalkThatThrowsTheBodyAside) {
  const Steps far_aside{{{0, 0.49, 0}, {0, -0.19, 0}, {0, 0.49, 0}, {0, -0.19, 0}}};
  WalkOptions options = walk_of(far_aside);
  options.com_height_m = 0.3;
  EXPECT_THAT(refusal_of(options),
              EndsWith("the cause is walk.com_height_m 0.3, with 0.814 the legs can follow"));
  options = walk_of(Steps{{{0, 0.44, 0}, {0, -0.19, 0}, {0, 0.44, 0}, {0, -0.19, 0}}});
  options.preview_s = 0.1;
  EXPECT_THAT(refusal_of(options), HasSubstr("the cause is walk.preview_s 0.1, with 1.6"));
}

TEST(PlanCause, IsTheRadiusOfATightCircle) {
  for (const Command& command : {Command(TangentArc{0.2, 1.5}), Command(PerpendicularArc{0.2, 1.5})})
    EXPECT_THAT(refusal_of(walk_of(command)), HasSubstr("_arc.radius_m 0.2, with 0.75 the legs can follow"));
}

TEST(PlanCause, IsTheFieldOfTheFirstStepThatIsBeyondTheLegs) {
  const Step good{0.1, 0.19, 0}, turned{0, 0.2, std::numbers::pi / 2}, far{0.9, -0.19, 0};
  EXPECT_THAT(refusal_of(walk_of(Steps{{turned}})),
              EndsWith("the cause is walk.commands[1].steps[0].turn_deg 90, with 0 the legs can follow"));
  EXPECT_THAT(refusal_of(walk_of(Steps{{good, far, good}})),
              EndsWith("the cause is walk.commands[1].steps[1].forward_m 0.9, with 0 the legs can follow"));
}

TEST(PlanCause, IsNoneWhereSeveralKeysAreWrong) {
  WalkOptions options = walk_of(Straight{0, 1});
  EXPECT_EQ(cause_of_infeasible(options, 1, [](const WalkOptions&) { return false; }),
            "no single key is the cause");
  EXPECT_EQ(cause_of_infeasible(options, 1, [](const WalkOptions&) { return true; }),
            "no single key is the cause")
      << "without the rest the command is feasible";
}

}  // namespace

}  // namespace walking
