// What the plan asks of the whole robot, by its multibody model: ZMP with and without the second preview
// stage, yaw momentum with and without moving arms.
#include <gtest/gtest.h>

#include <algorithm>

#include "sim/world/nominal_body.h"
#include "tests/sim/world/half_sitting_world.h"
#include "walking/pattern_generator.h"

namespace sim::world {
namespace {

struct Played {
  Eigen::Vector2d zmp_error = Eigen::Vector2d::Zero();  // largest, in the waist's axes, m
  double yaw_moment = 0;                                // largest, about the centre of mass, N·m
};

Played played(bool second_preview, walking::ArmMotion arms) {
  walking::WalkOptions walk;
  walk.commands = {walking::TangentArc{0.75, 0.8}};
  walk.second_preview = second_preview;
  walk.arm_motion = arms;
  const walking::WholeBody body = nominal_body("hrp2", models());
  walking::PatternGenerator plan(walk, body);
  walking::Reference before = plan.next(), now = plan.next();
  walking::BodyMomentum first = body(walking::motion_between(pose_of(before), pose_of(now)));
  Played most;
  for (std::size_t k = 2; k < plan.ticks(); ++k) {
    const walking::Reference after = plan.next();
    const walking::BodyMomentum second = body(walking::motion_between(pose_of(now), pose_of(after)));
    const Eigen::Vector2d error = now.zmp_reference - walking::multibody_zmp(first, second);
    const Eigen::Matrix2d R_PB = now.X_PB.linear().topLeftCorner<2, 2>();
    most.zmp_error = most.zmp_error.cwiseMax((R_PB.transpose() * error).cwiseAbs());
    const double moment = (second.angular - first.angular).z() / walking::kPeriod;
    most.yaw_moment = std::max(most.yaw_moment, std::abs(moment));
    now = after;
    first = second;
  }
  return most;
}

TEST(SecondPreview, KeepsTheWholeRobotsZmpAsCloseAsTheOriginalDoes) {
  const Played one = played(false, walking::ArmMotion::still), two = played(true, walking::ArmMotion::still);
  // The original reports 12 mm ahead and 4 mm aside; aside, 20 ms of double support leave 2 mm more.
  EXPECT_LT(two.zmp_error.x(), 0.0065);
  EXPECT_LT(two.zmp_error.y(), 0.0065);
  EXPECT_GT(one.zmp_error.x(), 0.015);
  EXPECT_GT(one.zmp_error.y(), 0.015);
}

TEST(ArmMomentum, TakesUpMostOfTheYawMomentOfATurn) {
  const double still = played(true, walking::ArmMotion::still).yaw_moment;
  EXPECT_LT(played(true, walking::ArmMotion::swing).yaw_moment, still);
  EXPECT_LT(played(true, walking::ArmMotion::momentum).yaw_moment, still / 3);
}

}  // namespace
}  // namespace sim::world
