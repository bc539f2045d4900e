#include "walking/second_preview.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/walking/smooth_walk.h"
#include "walking/hrp2.h"
#include "walking/kinematics.h"
#include "walking/pattern_generator.h"

namespace walking {
namespace {

struct PointMass {
  double mass;
  Eigen::Vector3d position;  // in P
};

/// Momentum of point masses that ride on the robot; their velocities by central differences along the motion.
template <class Masses>
BodyMomentum momentum_of(const Masses& masses, const BodyMotion& motion) {
  constexpr double h = 1e-4;
  const auto moved = [&](double dt) {
    BodyPose pose = motion.pose;
    pose.X_PB.translation() += dt * motion.v;
    if (motion.w.norm() > 0) {
      pose.X_PB.linear() =
          Eigen::AngleAxisd(dt * motion.w.norm(), motion.w.normalized()) * motion.pose.X_PB.linear();
    }
    pose.q += dt * motion.dq;
    return masses(pose);
  };
  const auto now = masses(motion.pose), before = moved(-h), after = moved(h);
  BodyMomentum total;
  for (const PointMass& m : now) {
    total.mass += m.mass;
    total.com += m.mass * m.position;
  }
  total.com /= total.mass;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const Eigen::Vector3d p = now[i].mass * (after[i].position - before[i].position) / (2 * h);
    total.linear += p;
    total.angular += (now[i].position - total.com).cross(p);
  }
  return total;
}

/// All mass at the plan's center of mass: the cart-table itself.
std::vector<PointMass> one_mass(const BodyPose& pose) {
  return {{hrp2::kMass, pose.X_PB * hrp2::kComInWaist}};
}

/// A heavy trunk and legs of 8.16 kg, each half at its ankle and half between hip and ankle; together where
/// the robot's center of mass is in half-sitting.
std::vector<PointMass> trunk_and_legs(const BodyPose& pose) {
  constexpr double kTotal = hrp2::kMass, kLeg = 8.16;
  const auto leg = [](Side side, const Eigen::Matrix<double, 6, 1>& q) {
    const Eigen::Vector3d ankle = sole_in_waist(side, q) * Eigen::Vector3d(0, 0, hrp2::kAnkleHeight);
    const Eigen::Vector3d hip(0, side == Side::left ? hrp2::kHipY : -hrp2::kHipY, 0);
    return std::vector<PointMass>{{kLeg / 2, ankle}, {kLeg / 2, (hip + ankle) / 2}};
  };
  std::vector<PointMass> masses = leg(Side::right, pose.q.segment<6>(0));
  for (const PointMass& m : leg(Side::left, pose.q.segment<6>(6))) masses.push_back(m);
  const Eigen::Vector3d half_sitting_ankle(hrp2::kAnkleX, 0, hrp2::kAnkleHeight - hrp2::kWaistHeight);
  const Eigen::Vector3d legs = 2 * kLeg * 0.75 * half_sitting_ankle;
  masses.push_back({kTotal - 2 * kLeg, (kTotal * hrp2::kComInWaist - legs) / (kTotal - 2 * kLeg)});
  for (PointMass& m : masses) m.position = pose.X_PB * m.position;
  return masses;
}

template <class Masses>
WholeBody model_of(Masses masses) {
  return [=](const BodyMotion& motion) { return momentum_of(masses, motion); };
}

WalkOptions two_steps() {
  WalkOptions options;
  options.com_height_m = hrp2::kWaistHeight + hrp2::kComInWaist.z();
  options.commands = {Stand{2}, Straight{0.6, -0.1}, Stand{1}, TangentArc{0.75, 0.8}, Stand{2}};
  return options;
}

WalkOptions with_second_preview(WalkOptions options = two_steps()) {
  options.second_preview = true;
  return options;
}

/// ZMP of `model` when it moves as planned, at ticks 1 ... n - 2.
std::vector<Eigen::Vector2d> played(const std::vector<Reference>& walk, const WholeBody& model) {
  std::vector<BodyMomentum> between;
  for (std::size_t k = 1; k < walk.size(); ++k) {
    between.push_back(model(motion_between(pose_of(walk[k - 1]), pose_of(walk[k]))));
  }
  std::vector<Eigen::Vector2d> zmp;
  for (std::size_t k = 1; k < between.size(); ++k) zmp.push_back(multibody_zmp(between[k - 1], between[k]));
  return zmp;
}

struct Error {
  double rms = 0, largest = 0;
};

Error zmp_error(const std::vector<Reference>& walk, const WholeBody& model) {
  const auto zmp = played(walk, model);
  Error error;
  for (std::size_t i = 0; i < zmp.size(); ++i) {
    const double e = (zmp[i] - walk[i + 1].zmp_reference).norm();
    error.rms += e * e / static_cast<double>(zmp.size());
    error.largest = std::max(error.largest, e);
  }
  error.rms = std::sqrt(error.rms);
  return error;
}

TEST(MotionBetween, LeadsFromOnePoseToTheOther) {
  BodyPose before, after;
  before.X_PB =
      Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, -1).normalized());
  const Eigen::Vector3d turn(0.02, -0.01, 0.03);
  after.X_PB.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * before.X_PB.linear();
  after.X_PB.translation() << 1.01, 2, 2.98;
  after.q.setConstant(0.1);
  const BodyMotion motion = motion_between(before, after, kPeriod);
  EXPECT_LT((motion.w * kPeriod - turn).norm(), 1e-14);
  EXPECT_LT((motion.v - Eigen::Vector3d(2, 0, -4)).norm(), 1e-12);
  EXPECT_LT((motion.dq.array() - 20).abs().maxCoeff(), 1e-12);
  EXPECT_LT((motion.pose.q.array() - 0.05).abs().maxCoeff(), 1e-15);
  const Eigen::Matrix3d half = Eigen::AngleAxisd(turn.norm() / 2, turn.normalized()) * before.X_PB.linear();
  EXPECT_TRUE(motion.pose.X_PB.linear().isApprox(half, 1e-14));
}

TEST(MultibodyZmp, OfABodyAtRestIsBelowItsCenterOfMass) {
  BodyMomentum still;
  still.mass = 50;
  still.com << 3, -2, 0.8;
  EXPECT_LT((multibody_zmp(still, still) - still.com.head<2>()).norm(), 1e-14);
}

TEST(MultibodyZmp, OfOneMassIsTheCartTables) {
  const WalkOptions options = two_steps();
  const auto walk = planned(options);
  const auto zmp = played(walk, model_of(one_mass));
  for (std::size_t i = 0; i < zmp.size(); ++i) {
    // Differences see the acceleration's mean over two ticks, the cart-table that at the tick.
    const Eigen::Vector3d mean =
        walk[i + 1].com_acceleration / 1.5 + (walk[i].com_acceleration + walk[i + 2].com_acceleration) / 6;
    const Eigen::Vector2d expected =
        walk[i + 1].com.head<2>() - options.com_height_m / kGravity * mean.head<2>();
    ASSERT_LT((zmp[i] - expected).norm(), 5e-5)
        << "at " << walk[i + 1].t_s;  // position's mean: acceleration T² / 2
  }
}

TEST(MultibodyZmp, TurningUpperBodyShowsAsMoment) {
  BodyMomentum before, after;
  before.mass = after.mass = 50;
  before.com << 0, 0, 0.8;
  after.com = before.com;
  after.angular << 0, 50 * kGravity * kPeriod * 0.02,
      0;  // the moment that 2 cm of ZMP behind the mass would cause
  EXPECT_LT((multibody_zmp(before, after) - Eigen::Vector2d(-0.02, 0)).norm(), 1e-14);
}

TEST(SecondPreview, LeavesTheCartTableAsItIs) {
  WalkOptions options = two_steps();
  const auto first = planned(options);
  const auto second = planned(PatternGenerator(with_second_preview(options), model_of(one_mass)));
  ASSERT_EQ(first.size(), second.size());
  double moved = 0;
  for (std::size_t k = 0; k < first.size(); ++k) {
    EXPECT_EQ(first[k].t_s, second[k].t_s);
    moved = std::max(moved, (first[k].com - second[k].com).norm());
  }
  EXPECT_LT(moved, 0.005);  // it corrects the first stage's own tracking error, 16 mm for 20 ms at most
}

TEST(SecondPreview, MakesTheWholeBodysZmpFollowTheReference) {
  const WholeBody model = model_of(trunk_and_legs);
  const Error without = zmp_error(planned(two_steps()), model);
  const Error with = zmp_error(planned(PatternGenerator(with_second_preview(), model)), model);
  EXPECT_LT(with.rms, without.rms / 5);  // 13.2 mm and 1.8 mm
  EXPECT_LT(with.largest, 0.010);  // 28 mm and 8.5 mm: what preview control itself leaves of a smoothed step
}

TEST(SecondPreview, KeepsFeetHeadingAndTheWaistsPlaceUnderTheCenterOfMass) {
  const auto first = planned(two_steps());
  const auto second = planned(PatternGenerator(with_second_preview(), model_of(trunk_and_legs)));
  for (std::size_t k = 0; k < first.size(); ++k) {
    ASSERT_TRUE(first[k].X_PL.matrix() == second[k].X_PL.matrix());
    ASSERT_TRUE(first[k].X_PR.matrix() == second[k].X_PR.matrix());
    ASSERT_TRUE(first[k].X_PB.linear() == second[k].X_PB.linear());
    ASSERT_LT((second[k].X_PB * hrp2::kComInWaist - second[k].com).norm(), 1e-14);
    ASSERT_LT((second[k].waist_velocity - first[k].waist_velocity -
               (second[k].com_velocity - first[k].com_velocity))
                  .norm(),
              1e-14);
  }
}

TEST(SecondPreview, StartsInHalfSittingEvenIfTheModelsMassIsElsewhere) {
  const WholeBody lopsided = [](const BodyMotion& motion) {
    BodyMomentum m = momentum_of(one_mass, motion);
    m.com.y() += 0.00155;
    return m;
  };
  const auto walk = planned(PatternGenerator(with_second_preview(), lopsided));
  EXPECT_LT((walk.front().com.head<2>() - hrp2::kComInWaist.head<2>()).norm(), 1e-15);
  EXPECT_LT(walk[1].com_acceleration.norm(), 0.1);  // m/s²; 0.56 if the offset came in at once
  EXPECT_NEAR(walk.back().com.y() - planned(two_steps()).back().com.y(), -0.00155, 1e-4);
}

}  // namespace
}  // namespace walking
