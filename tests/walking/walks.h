// Planned walks for tests, each continuous in ZMP, center of mass, waist, feet and their velocities.
#pragma once

#include "tests/walking/robots.h"
#include "walking/pattern_generator.h"

namespace walking {

inline const Robot kRobot = hrp2_robot();  ///< robot of all tests that do not choose another

inline constexpr double kDegree = std::numbers::pi / 180;

inline WalkOptions walk_of(std::vector<Command> commands) {
  WalkOptions options;
  options.commands = std::move(commands);
  return options;
}

inline std::vector<Reference> planned(PatternGenerator generator) {
  std::vector<Reference> walk;
  for (std::size_t k = 0; k < generator.ticks(); ++k) walk.push_back(generator.next());
  return walk;
}
inline std::vector<Reference> planned(const WalkOptions& options) {
  return planned(PatternGenerator(kRobot, options));
}

/// The robot half-sitting, with its feet together and the ZMP under the center of mass.
inline Reference standing() {
  Reference reference;
  reference.com = kRobot.com + Eigen::Vector3d(0, 0, kRobot.base_height);
  reference.zmp = reference.zmp_reference = reference.com.head<2>();
  reference.X_PB.translation().z() = kRobot.base_height;
  reference.X_PL.translation() << kRobot.sole_ahead, kRobot.foot_spacing / 2, 0;
  reference.X_PR.translation() << kRobot.sole_ahead, -kRobot.foot_spacing / 2, 0;
  return reference;
}

inline double yaw_of(const Eigen::Isometry3d& X) { return std::atan2(X.linear()(1, 0), X.linear()(0, 0)); }

/// Speed between two ticks, m/s.
inline double speed(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (b.translation() - a.translation()).norm() / kPeriod;
}

/// Turning rate between two ticks, rad/s.
inline double turning(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return std::remainder(yaw_of(b) - yaw_of(a), 2 * std::numbers::pi) / kPeriod;
}

/// Expects that the derivatives of the center of mass agree and that its jerk (m/s³) and the steps of the ZMP
/// (m) are bounded.
inline void expect_smooth_body(const Reference& a, const Reference& b, double most_jerk, double most_step) {
  // The jerk is constant between ticks, so velocity and position follow exactly.
  const Eigen::Vector3d jerk = (b.com_acceleration - a.com_acceleration) / kPeriod;
  const Eigen::Vector3d velocity = a.com_velocity + kPeriod * (a.com_acceleration + kPeriod / 2 * jerk);
  const Eigen::Vector3d com =
      a.com + kPeriod * (a.com_velocity + kPeriod / 2 * (a.com_acceleration + kPeriod / 3 * jerk));
  ASSERT_LT(jerk.norm(), most_jerk);
  ASSERT_LT((b.com_velocity - velocity).norm(), 1e-12);
  ASSERT_LT((b.com - com).norm(), 1e-12);
  ASSERT_LT((b.zmp - a.zmp).norm(), most_step);
  ASSERT_LT((b.zmp_reference - a.zmp_reference).norm(), most_step);
  ASSERT_LT((b.zmp - b.zmp_reference).norm(), 0.02);
}

/// Expects that a foot moves only in the air and that its velocity does not jump. only: support by this foot
/// alone.
inline void expect_smooth_foot(const Reference* tick, Eigen::Isometry3d Reference::*foot, Support only,
                               double most_acceleration) {
  const Eigen::Isometry3d &earlier = tick[-2].*foot, &before = tick[-1].*foot, &now = tick->*foot;
  if (tick->support == only || (tick->support == Support::both && tick[-1].support == Support::both)) {
    ASSERT_TRUE(now.matrix() == before.matrix());
    ASSERT_EQ(now.translation().z(), 0);
  }
  ASSERT_LT(speed(before, now), 0.95);              // 0.8 m/s for a stride of 0.3 m
  ASSERT_LT(std::abs(turning(before, now)), 0.90);  // 1.5 · 0.4 rad / 0.70 s
  const Eigen::Vector3d change = now.translation() - 2 * before.translation() + earlier.translation();
  ASSERT_LT(change.norm() / kPeriod, kPeriod * most_acceleration);
}

inline void expect_smooth(const std::vector<Reference>& walk, double single_support_s = 0.78) {
  double widest = 0;
  for (const Reference& r : walk)
    widest = std::max(widest, (r.X_PL.translation() - r.X_PR.translation()).head<2>().norm());
  // The smoothing window's largest weight is a fifth of the way from foot to foot.
  const double zmp_step = 0.2 * widest, jerk = zmp_step * kGravity / 0.81 / kPeriod;
  const double most_acceleration = 5 * std::pow(0.78 / single_support_s, 2);  // m/s², of a foot
  for (std::size_t k = 2; k < walk.size(); ++k) {
    const Reference &before = walk[k - 2], &now = walk[k - 1], &after = walk[k];
    expect_smooth_body(now, after, jerk, zmp_step);
    expect_smooth_foot(&after, &Reference::X_PL, Support::left, most_acceleration);
    expect_smooth_foot(&after, &Reference::X_PR, Support::right, most_acceleration);
    // Central differences of the waist's pose; the yaw acceleration jumps by 2.2 rad/s² at lift-off.
    const Eigen::Vector3d velocity = (after.X_PB.translation() - before.X_PB.translation()) / (2 * kPeriod);
    EXPECT_LT((now.waist_velocity - velocity).norm(), kPeriod * kPeriod / 6 * jerk);
    EXPECT_NEAR(now.waist_yaw_rate, turning(before.X_PB, after.X_PB) / 2, 6e-3);
    ASSERT_FALSE(testing::Test::HasFailure()) << "at " << after.t_s;
  }
}

}  // namespace walking
