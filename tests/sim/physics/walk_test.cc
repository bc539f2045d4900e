// The ends of short walks.
#include "tests/sim/physics/test_worlds.h"
#include "tests/walking/walks.h"
#include "walking/kinematics.h"
#include "walking/leg_odometry.h"

namespace sim::physics {
namespace {

using walking::walk_of;

TEST(Walk, GoesWhereThePlanGoesButForWhatItsFeetSlip) {
  const Walked walked = walk(walk_of({walking::Straight{0.6, 0}}), {});
  ASSERT_EQ(walked.status.condition, Condition::ok) << walked.status.cause;
  const Eigen::Vector3d drift = walked.X_PB.translation() - walked.planned.translation();
  EXPECT_LT(drift.norm(), 0.03);  // HRP-2's own order of drift on 1 m: a centimetre or two
  EXPECT_GT(drift.norm(), 1e-5);  // only its feet move the robot
}

TEST(Walk, TurnsAlongAnArc) {
  const Walked walked = walk(walk_of({walking::TangentArc{0.75, 0.8}}), {});
  ASSERT_EQ(walked.status.condition, Condition::ok) << walked.status.cause;
  EXPECT_LT((walked.X_PB.translation() - walked.planned.translation()).norm(), 0.04);
  EXPECT_NEAR(walking::yaw_of(walked.planned), 0.8, 1e-9);
  EXPECT_NEAR(walking::yaw_of(walked.X_PB), 0.8, 0.03);  // drift 0.1° (0.7°) over twice this turn, 4 sigma
}

TEST(Walk, GoesTheSameWayFiftyMetersFromTheOrigin) {
  const Walked here = walk(walk_of({walking::TangentArc{0.75, 0.6}}), {});
  const Walked there = walk(walk_of({walking::TangentArc{0.75, 0.6}}), {}, {}, {}, far_away());
  ASSERT_EQ(there.status.condition, Condition::ok) << there.status.cause;
  // Rounding differs, and what slips at the limit of friction doubles it many times over.
  EXPECT_LT((here.X_PB.translation() - there.X_PB.translation()).norm(), 0.001);
}

// The clock starts when the robot is at rest.
TEST(Walk, BeginsAtTimeZeroWithThePushesStillToCome) {
  WorldOptions options;
  options.pushes = {{.time_s = 0, .impulse_ns = 5, .direction_rad = 0, .duration_s = 0.1}};
  const auto moved = [](const WorldOptions& world) {
    WalkingRobot robot(walking::PatternGenerator(walk_of({walking::Stand{1}})), {}, world, {},
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
  EXPECT_EQ(walk(walk_of({walking::Straight{1.0, 0}}), off).status.condition, Condition::fell);
}

// Errors of the loaded soles in the waist, mean of positions (m) and angles (rad).
TEST(Walk, LegOdometryKnowsWhereTheSolesAreBecauseItKnowsTheBushes) {
  WalkingRobot robot(walking::PatternGenerator(walk_of({walking::TangentArc{0.75, 0.6}})), {}, {}, {},
                     {"hrp2", "office", models()});
  Eigen::Vector2d encoders = Eigen::Vector2d::Zero(), with_bushes = encoders;
  double count = 0;
  while (robot.walks()) {
    robot.tick();
    const World& world = robot.world();
    const walking::SensorReadings readings = world.leg_readings();
    for (const auto side : {walking::Side::left, walking::Side::right}) {
      const bool left = side == walking::Side::left;
      const walking::Wrench& wrench = left ? readings.left : readings.right;
      if (wrench.force.z() < 100) continue;
      const Eigen::Isometry3d truth = world.X_WB().inverse() * (left ? world.X_WL() : world.X_WR());
      const auto error = [&](const Eigen::Isometry3d& X_BS) {
        return Eigen::Vector2d((X_BS.translation() - truth.translation()).norm(),
                               Eigen::AngleAxisd(X_BS.linear().transpose() * truth.linear()).angle());
      };
      const auto q = readings.q.segment<6>(left ? walking::hrp2::kLeftLeg : walking::hrp2::kRightLeg);
      encoders += error(walking::sole_in_waist(side, q));
      with_bushes += error(walking::measured_sole_in_waist(side, q, wrench));
      ++count;
    }
  }
  EXPECT_TRUE((with_bushes.array() < 0.3 * encoders.array()).all());
  EXPECT_LT(with_bushes.x() / count, 2e-4);
  EXPECT_LT(with_bushes.y() / count, 2e-3);
}

}  // namespace
}  // namespace sim::physics
