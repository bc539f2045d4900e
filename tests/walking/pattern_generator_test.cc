#include "walking/pattern_generator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "walking/hrp2.h"
#include "walking/inverse_kinematics.h"
#include "walking/leg_limits.h"

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

std::vector<Reference> planned(const WalkOptions& options) {
  PatternGenerator generator(options);
  std::vector<Reference> walk;
  for (std::size_t k = 0; k < generator.ticks(); ++k) walk.push_back(generator.next());
  return walk;
}

double yaw_of(const Eigen::Isometry3d& X) { return std::atan2(X.linear()(1, 0), X.linear()(0, 0)); }

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

TEST_P(WholeWalk, CentreOfMassIsSmoothAndItsDerivativesAgree) {
  for (std::size_t k = 1; k < walk_.size(); ++k) {
    const Reference &a = walk_[k - 1], &b = walk_[k];
    const Eigen::Vector3d jerk = (b.com_acceleration - a.com_acceleration) / kPeriod;
    ASSERT_LT(jerk.norm(), 170) << "at " << b.t_s;  // g / z_c times 0.07 m of ZMP in 5 ms
    // Between ticks the jerk is constant: velocity and position follow exactly.
    const Eigen::Vector3d velocity = a.com_velocity + kPeriod * (a.com_acceleration + kPeriod / 2 * jerk);
    const Eigen::Vector3d com =
        a.com + kPeriod * (a.com_velocity + kPeriod / 2 * (a.com_acceleration + kPeriod / 3 * jerk));
    ASSERT_LT((b.com_velocity - velocity).norm(), 1e-12);
    ASSERT_LT((b.com - com).norm(), 1e-12);
  }
}

TEST_P(WholeWalk, ZmpIsContinuousAndFollowsItsReference) {
  for (std::size_t k = 1; k < walk_.size(); ++k) {
    // The smoothing window's largest weight is a fifth; the feet are 0.35 m apart at most.
    ASSERT_LT((walk_[k].zmp - walk_[k - 1].zmp).norm(), 0.07) << "at " << walk_[k].t_s;
    ASSERT_LT((walk_[k].zmp_reference - walk_[k - 1].zmp_reference).norm(), 0.07) << "at " << walk_[k].t_s;
    ASSERT_LT((walk_[k].zmp - walk_[k].zmp_reference).norm(), 0.02) << "at " << walk_[k].t_s;
  }
}

TEST_P(WholeWalk, WaistVelocityIsTheDerivativeOfItsPose) {
  for (std::size_t k = 1; k + 1 < walk_.size(); ++k) {
    const Reference &before = walk_[k - 1], &now = walk_[k], &after = walk_[k + 1];
    const Eigen::Vector3d velocity = (after.X_PB.translation() - before.X_PB.translation()) / (2 * kPeriod);
    const double rate = std::remainder(yaw_of(after.X_PB) - yaw_of(before.X_PB), 2 * kPi) / (2 * kPeriod);
    // Central differences: T²/6 times the jerk, 3.3e-4 m/s; the yaw's acceleration jumps by 2.2 rad/s² at
    // lift-off.
    ASSERT_LT((now.waist_velocity - velocity).norm(), 6e-4) << "at " << now.t_s;
    ASSERT_NEAR(now.waist_yaw_rate, rate, 6e-3) << "at " << now.t_s;
  }
}

TEST_P(WholeWalk, WaistStaysUprightAtItsHeightWithTheCentreOfMassAtItsPlace) {
  for (const Reference& r : walk_) {
    ASSERT_EQ(r.X_PB.linear().col(2), Eigen::Vector3d::UnitZ());
    ASSERT_NEAR(r.X_PB.translation().z(), hrp2::kWaistHeight, 1e-15);
    ASSERT_LT((r.X_PB * hrp2::kComInWaist - r.com).norm(), 1e-14);
  }
}

/// Speed, m/s, and turning rate, rad/s, between two ticks.
double speed(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (b.translation() - a.translation()).norm() / kPeriod;
}
double turning(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return std::abs(std::remainder(yaw_of(b) - yaw_of(a), 2 * kPi)) / kPeriod;
}

TEST_P(WholeWalk, FeetMoveSmoothlyAndOnlyInTheAir) {
  for (const auto foot : {&Reference::X_PL, &Reference::X_PR}) {
    const Support alone = foot == &Reference::X_PL ? Support::left : Support::right;
    for (std::size_t k = 1; k < walk_.size(); ++k) {
      const Eigen::Isometry3d &before = walk_[k - 1].*foot, &now = walk_[k].*foot;
      if (walk_[k].support == alone || (walk_[k].support == Support::both && walk_[k - 1].support != alone &&
                                        walk_[k - 1].support == Support::both)) {
        ASSERT_TRUE(now.matrix() == before.matrix()) << "at " << walk_[k].t_s;
        ASSERT_EQ(now.translation().z(), 0);
      }
      ASSERT_LT(speed(before, now), 0.95);    // 0.8 m/s for a stride of 0.3 m
      ASSERT_LT(turning(before, now), 0.90);  // 1.5 · 0.4 rad / 0.70 s
      if (k < 2) continue;
      const Eigen::Isometry3d& earlier = walk_[k - 2].*foot;
      const Eigen::Vector3d change = now.translation() - 2 * before.translation() + earlier.translation();
      ASSERT_LT(change.norm() / kPeriod, 0.025)
          << "at " << walk_[k].t_s;  // velocity: 4.6 m/s² in 5 ms at most
    }
  }
}

TEST_P(WholeWalk, LegsCanFollow) {
  for (const Reference& r : walk_) {
    ASSERT_FALSE(legs_prevent(inverse_kinematics(posture_of(r))).has_value()) << "at " << r.t_s;
  }
}

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
  // Centre of the feet and heading after each command.
  const double x[] = {0, 1, 1, 1.75, 1.75, 1, 1, .25, .25, 1, 1};
  const double y[] = {0, -.5, -.5, .25, .25, 1, 1, .25, .25, -.5, -.5};
  const double quarters[] = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4};
  const auto expect_together = [&](int command, const Reference& r) {
    const double yaw = quarters[command] * kPi / 2;
    const Eigen::Vector2d left = 0.095 * Eigen::Vector2d(-std::sin(yaw), std::cos(yaw));
    // The circle goes through the feet's centre, which starts kAnkleX ahead of P's origin.
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
  options.step_length_m = 0.45;
  options.commands = {Stand{1}, Straight{2, 0}};
  try {
    PatternGenerator generator(options);
    FAIL() << "a stride of 0.9 m was accepted";
  } catch (const std::invalid_argument& e) {
    const std::string said = e.what();
    EXPECT_NE(said.find("walk.commands[1]"), std::string::npos) << said;
    EXPECT_NE(said.find("walk.step_length_m"), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace walking
