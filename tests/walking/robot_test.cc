#include "walking/robot.h"

#include "tests/walking/robots.h"
#include "walking/pattern_generator.h"

namespace walking {
namespace {

double uniform(std::mt19937_64& bits) { return static_cast<double>(bits() >> 11) * 0x1p-53; }

/// Uniform within the ranges, but the knee (joint 3) at least `bent` from stretched and the hip well above
/// the plane of the sole.
LegVector random_leg(const Robot& robot, Side side, std::mt19937_64& bits, double bent) {
  LegVector q;
  for (int i = 0; i < 6; ++i) {
    const Joint& joint =
        robot.joints[static_cast<std::size_t>(robot.leg(side).joints[static_cast<std::size_t>(i)])];
    q[i] = joint.lowest + uniform(bits) * (joint.highest - joint.lowest);
  }
  const bool above =
      sole_in_base(robot, side, q).inverse().translation().z() > robot.leg(side).ankle().z() + 0.1;
  return std::abs(q[3]) > bent && above ? q : random_leg(robot, side, bits, bent);
}

LegVector near(const LegVector& q, double distance, std::mt19937_64& bits) {
  LegVector other = q;
  for (double& angle : other) angle += distance * (2 * uniform(bits) - 1);
  return other;
}

// Ten decimals from a published model.
TEST(LegKinematics, TheReferencePoseOfTheLeftLegIsReproducedForwardAndInverse) {
  const Robot robot = hrp2_robot();
  const LegVector q(.1, -.05, -.5, .9, -.45, .08);
  Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();
  X_BA.translation() << .0260698066, .0706436577, -.5406679869;
  X_BA.linear() << .9935112935, -.1037621130, -.0465696631, .1021940891, .9941527387, -.0348812308,
      .0499167083, .0298957525, .9983058480;
  const Eigen::Isometry3d X_BS = X_BA * Eigen::Translation3d(-robot.leg(Side::left).ankle());
  EXPECT_LT((sole_in_base(robot, Side::left, q).matrix() - X_BS.matrix()).cwiseAbs().maxCoeff(), 1e-10);
  const LegSolution left =
      leg_inverse_kinematics(robot, Side::left, X_BS, leg_angles(robot.leg(Side::left), robot.posture));
  EXPECT_TRUE(left.reached);
  EXPECT_LT((left.q - q).cwiseAbs().maxCoeff(), 1e-8);  // ten decimals through the knee's slope
}

// Starts from the angles of one 5 ms tick earlier at 10 rad/s. Few poses have other solutions near a
// singularity.
TEST(LegKinematics, FindsTheAnglesOfEachPoseForAnyJointOrderAndObliqueAxes) {
  for (const auto& [robot, bent, most_others] :
       {std::tuple(hrp2_robot(), 0.05, 0), {made_up_robot(), 0.1, 80}}) {
    std::mt19937_64 bits(1);
    int others = 0;
    for (int i = 0; i < 8000; ++i) {
      const Side side = i % 2 == 0 ? Side::left : Side::right;
      const LegVector q = random_leg(robot, side, bits, bent);
      const Eigen::Isometry3d X_BS = sole_in_base(robot, side, q);
      const LegSolution found = leg_inverse_kinematics(robot, side, X_BS, near(q, 0.05, bits));
      ASSERT_TRUE(found.reached) << q.transpose();
      ASSERT_LT((sole_in_base(robot, side, found.q).matrix() - X_BS.matrix()).norm(), 1e-9);
      others += (found.q - q).cwiseAbs().maxCoeff() > 1e-9;
    }
    EXPECT_LE(others, most_others) << robot.name;
  }
}

/// A sole moved by `by` (ahead, aside and up, m) from its place in the start posture, and turned by `yaw`
/// (rad).
Eigen::Isometry3d moved_sole(const Robot& robot, Side side, const Eigen::Vector3d& by, double yaw = 0) {
  Eigen::Isometry3d X = sole_in_base(robot, side, leg_angles(robot.leg(side), robot.posture));
  X.pretranslate(by);
  return X * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
}

TEST(LegKinematics, FindsAllStepsFromTheStartPosture) {
  for (const Robot& robot : {hrp2_robot(), made_up_robot()})
    for (const double ahead : {-0.2, 0.0, 0.2})
      for (const double out : {0.0, 0.1, 0.2})
        for (const double yaw : {-0.3, 0.0, 0.3})
          for (const Side side : {Side::left, Side::right}) {
            const double sign = side == Side::left ? 1 : -1;
            const Eigen::Isometry3d X = moved_sole(robot, side, {ahead, sign * out, 0.06}, yaw);
            const LegSolution found =
                leg_inverse_kinematics(robot, side, X, leg_angles(robot.leg(side), robot.posture));
            EXPECT_EQ(leg_obstacle(robot, side, found), std::nullopt) << robot.name << ahead << out << yaw;
            EXPECT_LT((sole_in_base(robot, side, found.q).matrix() - X.matrix()).norm(), 1e-12);
          }
}

TEST(LegKinematics, ReportsWhyALegCannotTakeAPose) {
  using testing::HasSubstr, testing::Optional;
  const Robot robot = made_up_robot();
  const auto obstacle = [&](const Eigen::Vector3d& by, double yaw) {
    const LegVector start = leg_angles(robot.leg(Side::left), robot.posture);
    const LegSolution found =
        leg_inverse_kinematics(robot, Side::left, moved_sole(robot, Side::left, by, yaw), start);
    EXPECT_TRUE(found.q.allFinite());
    return leg_obstacle(robot, Side::left, found);
  };
  EXPECT_THAT(obstacle({0.6, 0, 0}, 0), Optional(std::string("the left foot is out of the leg's reach")));
  EXPECT_THAT(obstacle({0, 0, 2}, 0), Optional(HasSubstr("out of the leg's reach")));
  EXPECT_THAT(obstacle({0, 0, 0.02}, 1.9),
              Optional(HasSubstr("the left leg's joint port_twist would have to turn to ")));
}

TEST(LegKinematics, AFootThatWasOutOfReachCanBeReachedAgain) {
  const Robot robot = hrp2_robot();
  LegVector q = leg_angles(robot.leg(Side::left), robot.posture);
  for (const double down : {0.0, -0.03, -0.1, -0.03, 0.0, 0.05}) {
    const LegSolution found =
        leg_inverse_kinematics(robot, Side::left, moved_sole(robot, Side::left, {0, 0, down}), q);
    EXPECT_EQ(found.reached, down > -0.05) << down;
    EXPECT_EQ(leg_obstacle(robot, Side::left, found).has_value(), !found.reached);
    q = found.q;
  }
}

TEST(Robot, MayHaveLegsOfFiveJointsThatNoPlanWalks) {
  const Robot six = hrp2_robot();
  Robot five = six;
  for (Leg& leg : five.legs) {
    const Joint& roll = five.joints[static_cast<std::size_t>(leg.joints.back())];
    leg.X_FS = Eigen::Translation3d(roll.offset) *
               Eigen::AngleAxisd(five.posture[leg.joints.back()], roll.axis) * leg.X_FS;
    leg.joints.pop_back();
  }
  five.base_height = 0;
  measure(five);
  EXPECT_NEAR(five.base_height, six.base_height, 1e-12);
  EXPECT_NEAR(five.foot_spacing, six.foot_spacing, 1e-12);
  JointVector q = five.posture;
  set_leg_angles(five.leg(Side::left), LegVector::Constant(0.1), q);
  EXPECT_EQ((q.array() == 0.1).count(), 5);
  EXPECT_EQ(leg_angles(five.leg(Side::left), q)[5], 0);
  WalkOptions options;
  options.commands = {Stand{1}};
  EXPECT_THAT([&] { PatternGenerator(five, options); },
              testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr(
                  "walk.controller: the built-in controller needs legs of 6 joints, found 5")));
}

Joint& left_knee(Robot& robot) { return robot.joints[static_cast<std::size_t>(robot.legs[1].joints[3])]; }

TEST(Robot, IsRejectedIfItsLegsAreUnsuitable) {
  for (const auto& [change, complaint] : std::vector<std::pair<void (*)(Robot&), const char*>>{
           {[](Robot& r) { r.legs[1].joints.push_back(0); }, "the left leg has 7 joints, expected 1 to 6"},
           {[](Robot& r) { std::swap(r.legs[1].joints[0], r.legs[1].joints[1]); },
            "the left leg is not a chain from base to foot"},
           {[](Robot& r) { left_knee(r).highest = INFINITY; }, "the left leg has no range at LLEG_JOINT3"},
           {[](Robot& r) { left_knee(r).lowest = 1; },
            "the left leg is beyond the range of LLEG_JOINT3 in the start posture"},
           {[](Robot& r) { r.posture.setZero(); },
            "leg cannot move its sole in every direction in the start posture"},
           {[](Robot& r) { r.posture[9] += 0.1; }, "the left sole is turned by 5.7"},
           {[](Robot& r) { r.legs[1].X_FS.translation().x() += 0.01; }, "the soles are not side by side"}}) {
    Robot robot = hrp2_robot();
    change(robot);
    EXPECT_THAT([&] { measure(robot); },
                testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr(complaint)));
  }
}

}  // namespace
}  // namespace walking
