// Plan, stabiliser, inverse kinematics and physics together: a short walk.
#include <gtest/gtest.h>

#include "tests/sim/world/half_sitting_world.h"
#include "walking/inverse_kinematics.h"
#include "walking/pattern_generator.h"

namespace sim::world {
namespace {

struct Walked {
  Status status;
  Eigen::Isometry3d X_WB, X_PB;  // W here: where P is
};

/// Walks with the plan's world P at X_WP.
Walked walk(std::vector<walking::Command> commands, const walking::StabilizerOptions& options,
            const Eigen::Isometry3d& X_WP = Eigen::Isometry3d::Identity()) {
  walking::WalkOptions walk;
  walk.commands = std::move(commands);
  walking::PatternGenerator generator(walk);
  walking::Stabilizer stabilizer(options);
  walking::Reference reference = generator.next();
  walking::JointVector q = walking::inverse_kinematics(walking::posture_of(reference)).q;
  World world(WorldOptions{}, {}, q, X_WP * reference.X_PB, models());
  for (std::size_t tick = 0; tick < generator.ticks() && world.status().condition == Condition::ok; ++tick) {
    const walking::JointVector next = walking::inverse_kinematics(stabilizer.step(reference, world.felt())).q;
    world.command(next, (next - q) / walking::kPeriod);
    q = next;
    run(world, 5);
    reference = generator.next();
  }
  return {world.status(), X_WP.inverse() * world.X_WB(), reference.X_PB};
}

TEST(Walk, GoesWhereThePlanGoesButForWhatItsFeetSlip) {
  const Walked walked = walk({walking::Straight{0.6, 0}}, {});
  ASSERT_EQ(walked.status.condition, Condition::ok) << walked.status.cause;
  const Eigen::Vector3d drift = walked.X_WB.translation() - walked.X_PB.translation();
  EXPECT_LT(drift.norm(), 0.03);  // HRP-2's own order of drift on 1 m: a centimetre or two
  EXPECT_GT(drift.norm(), 1e-5);  // and nothing carries the robot there but its feet
}

TEST(Walk, TurnsAlongAnArc) {
  const Walked walked = walk({walking::TangentArc{0.75, 0.8}}, {});
  ASSERT_EQ(walked.status.condition, Condition::ok) << walked.status.cause;
  EXPECT_LT((walked.X_WB.translation() - walked.X_PB.translation()).norm(), 0.04);
}

TEST(Walk, GoesTheSameWayFiftyMetresFromTheOrigin) {
  Eigen::Isometry3d far = Eigen::Isometry3d::Identity();
  far.translate(Eigen::Vector3d(50, -30, 0)).rotate(Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ()));
  const Walked here = walk({walking::TangentArc{0.75, 0.6}}, {});
  const Walked there = walk({walking::TangentArc{0.75, 0.6}}, {}, far);
  ASSERT_EQ(there.status.condition, Condition::ok) << there.status.cause;
  // Rounding differs, and what slips at the limit of friction doubles it many times over.
  EXPECT_LT((here.X_WB.translation() - there.X_WB.translation()).norm(), 0.001);
}

TEST(Walk, EndsInAFallWithoutTheStabilizer) {
  walking::StabilizerOptions off;
  off.enabled = false;
  EXPECT_EQ(walk({walking::Straight{1.0, 0}}, off).status.condition, Condition::fell);
}

}  // namespace
}  // namespace sim::world
