// Plan, stabiliser, inverse kinematics and physics together: a short walk.
#include <gtest/gtest.h>

#include "tests/sim/world/half_sitting_world.h"
#include "walking/inverse_kinematics.h"
#include "walking/pattern_generator.h"

namespace sim::world {
namespace {

struct Walked {
  Status status;
  Eigen::Isometry3d X_WB, X_PB;
};

Walked walk(std::vector<walking::Command> commands, const walking::StabilizerOptions& options) {
  walking::WalkOptions walk;
  walk.commands = std::move(commands);
  walking::PatternGenerator generator(walk);
  walking::Stabilizer stabilizer(options);
  walking::Reference reference = generator.next();
  walking::JointVector q = walking::inverse_kinematics(walking::posture_of(reference)).q;
  World world(WorldOptions{}, {}, q, reference.X_PB, models());
  for (std::size_t tick = 0; tick < generator.ticks() && world.status().condition == Condition::ok; ++tick) {
    const walking::JointVector next = walking::inverse_kinematics(stabilizer.step(reference, world.felt())).q;
    world.command(next, (next - q) / walking::kPeriod);
    q = next;
    run(world, 5);
    reference = generator.next();
  }
  return {world.status(), world.X_WB(), reference.X_PB};
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

TEST(Walk, EndsInAFallWithoutTheStabilizer) {
  walking::StabilizerOptions off;
  off.enabled = false;
  EXPECT_EQ(walk({walking::Straight{1.0, 0}}, off).status.condition, Condition::fell);
}

}  // namespace
}  // namespace sim::world
