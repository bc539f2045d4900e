#include "tests/walking/walks.h"
#include "walking/kinematics.h"

namespace walking {
namespace {

/// All mass at the plan's center of mass: the cart-table itself.
BodyMomentum one_mass(const BodyMotion& motion) {
  const Eigen::Vector3d offset = motion.pose.X_PB.linear() * hrp2::kComInWaist;
  return {.mass = hrp2::kMass,
          .com = motion.pose.X_PB.translation() + offset,
          .linear = hrp2::kMass * (motion.v + motion.w.cross(offset))};
}

/// The same with the mass of the real robot, which is 1.55 mm to the left.
BodyMomentum lopsided(const BodyMotion& motion) {
  BodyMomentum momentum = one_mass(motion);
  momentum.com.y() += 0.00155;
  return momentum;
}

WalkOptions two_steps() {
  WalkOptions options = walk_of({Stand{2}, Straight{0.6, -0.1}, Stand{1}, TangentArc{0.75, 0.8}, Stand{2}});
  options.com_height_m = hrp2::kWaistHeight + hrp2::kComInWaist.z();
  return options;
}

std::vector<Reference> with_second_preview(const WholeBody& model) {
  WalkOptions options = two_steps();
  options.second_preview = true;
  return planned(PatternGenerator(options, model));
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

TEST(MultibodyZmp, IsBelowABodyAtRestAndBehindOneWhoseUpperBodyTurnsForwards) {
  BodyMomentum still{.mass = 50, .com = {3, -2, 0.8}}, turning = still;
  EXPECT_LT((multibody_zmp(still, still) - Eigen::Vector2d(3, -2)).norm(), 1e-14);
  turning.angular.y() = 50 * kGravity * kPeriod * 0.02;  // the moment of 2 cm of ZMP behind the mass
  EXPECT_LT((multibody_zmp(still, turning) - Eigen::Vector2d(2.98, -2)).norm(), 1e-14);
}

TEST(MultibodyZmp, OfOneMassIsTheCartTables) {
  const auto walk = planned(two_steps());
  for (std::size_t k = 2; k < walk.size(); ++k) {
    const Reference &a = walk[k - 2], &b = walk[k - 1], &c = walk[k];
    const auto momentum = [](const Reference& from, const Reference& to) {
      return one_mass(motion_between(pose_of(from), pose_of(to)));
    };
    // Differences see the acceleration's mean over two ticks, the cart-table that at the tick.
    const Eigen::Vector3d mean = b.com_acceleration / 1.5 + (a.com_acceleration + c.com_acceleration) / 6;
    const Eigen::Vector3d expected = b.com - two_steps().com_height_m / kGravity * mean;
    const Eigen::Vector2d found = multibody_zmp(momentum(a, b), momentum(b, c));
    ASSERT_LT((found - expected.head<2>()).norm(), 5e-5) << "at " << b.t_s;  // acceleration T² / 2
  }
}

TEST(SecondPreview, LeavesTheCartTableWithItsFeetAndHeadingAsItIs) {
  const auto first = planned(two_steps()), second = with_second_preview(one_mass);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t k = 0; k < first.size(); ++k) {
    const Reference &a = first[k], &b = second[k];
    ASSERT_EQ(a.t_s, b.t_s);
    ASSERT_LT((a.com - b.com).norm(), 0.005);  // corrects the first stage's tracking error, at most 16 mm
    ASSERT_TRUE(a.X_PL.matrix() == b.X_PL.matrix());
    ASSERT_TRUE(a.X_PR.matrix() == b.X_PR.matrix());
    ASSERT_TRUE(a.X_PB.linear() == b.X_PB.linear());
    ASSERT_LT((b.X_PB * hrp2::kComInWaist - b.com).norm(), 1e-14);
    ASSERT_LT((b.waist_velocity - a.waist_velocity - (b.com_velocity - a.com_velocity)).norm(), 1e-14);
  }
}

TEST(SecondPreview, StartsInHalfSittingEvenIfTheModelsMassIsElsewhere) {
  const auto walk = with_second_preview(lopsided);
  EXPECT_LT((walk.front().com.head<2>() - hrp2::kComInWaist.head<2>()).norm(), 1e-15);
  EXPECT_LT(walk[1].com_acceleration.norm(), 0.1);  // m/s²; 0.56 if the offset came in at once
  EXPECT_NEAR(walk.back().com.y() - planned(two_steps()).back().com.y(), -0.00155, 1e-4);
}

}  // namespace
}  // namespace walking
