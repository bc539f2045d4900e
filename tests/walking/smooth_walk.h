// Properties of every planned walk: ZMP, center of mass, waist and feet are continuous, as are their
// velocities.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "walking/pattern_generator.h"

namespace walking {

inline constexpr double kDegree = std::numbers::pi / 180;

inline std::vector<Reference> planned(PatternGenerator generator) {
  std::vector<Reference> walk;
  for (std::size_t k = 0; k < generator.ticks(); ++k) walk.push_back(generator.next());
  return walk;
}

inline std::vector<Reference> planned(const WalkOptions& options) {
  return planned(PatternGenerator(options));
}

inline double yaw_of(const Eigen::Isometry3d& X) { return std::atan2(X.linear()(1, 0), X.linear()(0, 0)); }

/// How far the ZMP may move in a tick: the smoothing window's largest weight is a fifth of the way from foot
/// to foot.
inline double zmp_step(const std::vector<Reference>& walk) {
  double widest = 0;
  for (const Reference& r : walk) {
    widest = std::max(widest, (r.X_PL.translation() - r.X_PR.translation()).head<2>().norm());
  }
  return 0.2 * widest;
}

/// The jerk that moves the cart-table's ZMP by that much in a tick, m/s³.
inline double jerk_of(const std::vector<Reference>& walk) {
  constexpr double kComHeight = 0.81;
  return zmp_step(walk) * kGravity / kComHeight / kPeriod;
}

/// Its derivatives agree, and its jerk is bounded.
inline void expect_smooth_center_of_mass(const std::vector<Reference>& walk) {
  const double most = jerk_of(walk);
  for (std::size_t k = 1; k < walk.size(); ++k) {
    const Reference &a = walk[k - 1], &b = walk[k];
    const Eigen::Vector3d jerk = (b.com_acceleration - a.com_acceleration) / kPeriod;
    ASSERT_LT(jerk.norm(), most) << "at " << b.t_s;
    // Between ticks the jerk is constant: velocity and position follow exactly.
    const Eigen::Vector3d velocity = a.com_velocity + kPeriod * (a.com_acceleration + kPeriod / 2 * jerk);
    const Eigen::Vector3d com =
        a.com + kPeriod * (a.com_velocity + kPeriod / 2 * (a.com_acceleration + kPeriod / 3 * jerk));
    ASSERT_LT((b.com_velocity - velocity).norm(), 1e-12);
    ASSERT_LT((b.com - com).norm(), 1e-12);
  }
}

/// It follows its reference; neither jumps.
inline void expect_smooth_zmp(const std::vector<Reference>& walk) {
  const double most = zmp_step(walk);
  for (std::size_t k = 1; k < walk.size(); ++k) {
    ASSERT_LT((walk[k].zmp - walk[k - 1].zmp).norm(), most) << "at " << walk[k].t_s;
    ASSERT_LT((walk[k].zmp_reference - walk[k - 1].zmp_reference).norm(), most) << "at " << walk[k].t_s;
    ASSERT_LT((walk[k].zmp - walk[k].zmp_reference).norm(), 0.02) << "at " << walk[k].t_s;
  }
}

/// Its velocities are the derivatives of its pose.
inline void expect_smooth_waist(const std::vector<Reference>& walk) {
  const double difference =
      kPeriod * kPeriod / 6 * jerk_of(walk);  // of a derivative and its central difference
  for (std::size_t k = 1; k + 1 < walk.size(); ++k) {
    const Reference &before = walk[k - 1], &now = walk[k], &after = walk[k + 1];
    const Eigen::Vector3d velocity = (after.X_PB.translation() - before.X_PB.translation()) / (2 * kPeriod);
    const double rate =
        std::remainder(yaw_of(after.X_PB) - yaw_of(before.X_PB), 2 * std::numbers::pi) / (2 * kPeriod);
    // The yaw's acceleration jumps at lift-off, by 2.2 rad/s² at most.
    ASSERT_LT((now.waist_velocity - velocity).norm(), difference) << "at " << now.t_s;
    ASSERT_NEAR(now.waist_yaw_rate, rate, 6e-3) << "at " << now.t_s;
  }
}

/// Speed, m/s, and turning rate, rad/s, between two ticks.
inline double speed(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (b.translation() - a.translation()).norm() / kPeriod;
}
inline double turning(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return std::abs(std::remainder(yaw_of(b) - yaw_of(a), 2 * std::numbers::pi)) / kPeriod;
}

/// They move in the air only, and their velocities do not jump.
inline void expect_smooth_feet(const std::vector<Reference>& walk) {
  for (const auto foot : {&Reference::X_PL, &Reference::X_PR}) {
    const Support alone = foot == &Reference::X_PL ? Support::left : Support::right;
    for (std::size_t k = 1; k < walk.size(); ++k) {
      const Eigen::Isometry3d &before = walk[k - 1].*foot, &now = walk[k].*foot;
      if (walk[k].support == alone || (walk[k].support == Support::both && walk[k - 1].support != alone &&
                                       walk[k - 1].support == Support::both)) {
        ASSERT_TRUE(now.matrix() == before.matrix()) << "at " << walk[k].t_s;
        ASSERT_EQ(now.translation().z(), 0);
      }
      ASSERT_LT(speed(before, now), 0.95);    // 0.8 m/s for a stride of 0.3 m
      ASSERT_LT(turning(before, now), 0.90);  // 1.5 · 0.4 rad / 0.70 s
      if (k < 2) continue;
      const Eigen::Isometry3d& earlier = walk[k - 2].*foot;
      const Eigen::Vector3d change = now.translation() - 2 * before.translation() + earlier.translation();
      ASSERT_LT(change.norm() / kPeriod, 0.025)
          << "at " << walk[k].t_s;  // velocity: 4.6 m/s² in 5 ms at most
    }
  }
}

inline void expect_smooth(const std::vector<Reference>& walk) {
  expect_smooth_center_of_mass(walk);
  expect_smooth_zmp(walk);
  expect_smooth_waist(walk);
  expect_smooth_feet(walk);
}

}  // namespace walking
