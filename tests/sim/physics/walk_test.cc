// The ends of short walks.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/physics/test_worlds.h"
#include "tests/walking/smooth_walk.h"
#include "walking/hrp2.h"
#include "walking/kinematics.h"
#include "walking/leg_odometry.h"

namespace sim::physics {
namespace {

walking::WalkOptions commanded(walking::Command command) {
  walking::WalkOptions options;
  options.commands = {std::move(command)};
  return options;
}

TEST(Walk, GoesWhereThePlanGoesButForWhatItsFeetSlip) {
  const Walked walked = walk(commanded(walking::Straight{0.6, 0}), {});
  ASSERT_EQ(walked.status.condition, Condition::ok) << walked.status.cause;
  const Eigen::Vector3d drift = walked.X_PB.translation() - walked.planned.translation();
  EXPECT_LT(drift.norm(), 0.03);  // HRP-2's own order of drift on 1 m: a centimetre or two
  EXPECT_GT(drift.norm(), 1e-5);  // only its feet move the robot
}

TEST(Walk, TurnsAlongAnArc) {
  const Walked walked = walk(commanded(walking::TangentArc{0.75, 0.8}), {});
  ASSERT_EQ(walked.status.condition, Condition::ok) << walked.status.cause;
  EXPECT_LT((walked.X_PB.translation() - walked.planned.translation()).norm(), 0.04);
  EXPECT_NEAR(walking::yaw_of(walked.planned), 0.8, 1e-9);
  EXPECT_NEAR(walking::yaw_of(walked.X_PB), 0.8,
              0.03);  // drift of 0.1° (0.7°) over twice this turn, four sigma
}

TEST(Walk, GoesTheSameWayFiftyMetersFromTheOrigin) {
  const Walked here = walk(commanded(walking::TangentArc{0.75, 0.6}), {});
  const Walked there = walk(commanded(walking::TangentArc{0.75, 0.6}), {}, {}, {}, far_away());
  ASSERT_EQ(there.status.condition, Condition::ok) << there.status.cause;
  // Rounding differs, and what slips at the limit of friction doubles it many times over.
  EXPECT_LT((here.X_PB.translation() - there.X_PB.translation()).norm(), 0.001);
}

// The clock starts when the robot is at rest.
TEST(Walk, BeginsAtTimeZeroWithThePushesStillToCome) {
  WorldOptions options;
  options.pushes = {{.time_s = 0, .impulse_ns = 5, .direction_rad = 0, .duration_s = 0.1}};
  const auto moved = [](const WorldOptions& world) {
    WalkingRobot robot(walking::PatternGenerator(commanded(walking::Stand{1})), {}, world, {},
                       {"hrp2", world.room, models()});
    EXPECT_EQ(robot.world().time().count(), 0);
    const Eigen::Vector3d before = robot.world().com();
    for (int tick = 0; tick < 20; ++tick) robot.tick();
    return Eigen::Vector3d(robot.world().com() - before);
  };
  EXPECT_LT(moved({}).norm(), 2e-4);    // at rest
  EXPECT_GT(moved(options).x(), 1e-3);  // free, 5 Ns on 57 kg would be 4.4 mm in 0.1 s
}

TEST(Walk, EndsInAFallWithoutTheStabilizer) {
  walking::StabilizerOptions off;
  off.enabled = false;
  EXPECT_EQ(walk(commanded(walking::Straight{1.0, 0}), off).status.condition, Condition::fell);
}

/// How far from the truth the loaded soles of a walk are in the waist, mean of positions (m) and angles
/// (rad): by the encoders, and by the ankles' bushes too.
struct SoleErrors {
  Eigen::Vector2d encoders = Eigen::Vector2d::Zero(), with_bushes = Eigen::Vector2d::Zero();
};

SoleErrors sole_errors(const walking::WalkOptions& options) {
  WalkingRobot robot(walking::PatternGenerator(options), {}, {}, {}, {"hrp2", "office", models()});
  SoleErrors sum;
  double count = 0;
  while (robot.walks()) {
    robot.tick();
    const walking::SensorReadings readings = robot.world().leg_readings();
    const auto add = [&](walking::Side side, int first, const walking::Wrench& wrench,
                         const Eigen::Isometry3d& X_WS) {
      if (wrench.force.z() < 100) return;
      const Eigen::Isometry3d truth = robot.world().X_WB().inverse() * X_WS;
      const auto error = [&](const Eigen::Isometry3d& X_BS) {
        return Eigen::Vector2d((X_BS.translation() - truth.translation()).norm(),
                               Eigen::AngleAxisd(X_BS.linear().transpose() * truth.linear()).angle());
      };
      sum.encoders += error(walking::sole_in_waist(side, readings.q.segment<6>(first)));
      sum.with_bushes += error(walking::measured_sole_in_waist(side, readings.q.segment<6>(first), wrench));
      ++count;
    };
    add(walking::Side::left, walking::hrp2::kLeftLeg, readings.left, robot.world().X_WL());
    add(walking::Side::right, walking::hrp2::kRightLeg, readings.right, robot.world().X_WR());
  }
  sum.encoders /= count, sum.with_bushes /= count;
  return sum;
}

TEST(Walk, LegOdometryKnowsWhereTheSolesAreBecauseItKnowsTheBushes) {
  const SoleErrors errors = sole_errors(commanded(walking::TangentArc{0.75, 0.6}));
  EXPECT_LT(errors.with_bushes.x(), 0.3 * errors.encoders.x());
  EXPECT_LT(errors.with_bushes.y(), 0.3 * errors.encoders.y());
  EXPECT_LT(errors.with_bushes.x(), 2e-4);
  EXPECT_LT(errors.with_bushes.y(), 2e-3);
}

}  // namespace
}  // namespace sim::physics
