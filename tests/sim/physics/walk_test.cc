#include <gtest/gtest.h>

#include "tests/sim/physics/test_worlds.h"
#include "tests/walking/walks.h"
#include "walking/kinematics.h"
#include "walking/leg_odometry.h"

namespace sim::physics {
namespace {

using walking::walk_of;

// HRP-2's own order of drift on 1 m is a centimetre or two, and 0.1° (0.7°) over twice this turn.
TEST(Walk, GoesWhereThePlanGoesButForWhatItsFeetSlip) {
  for (const auto& [command, turn, most_m] :
       {std::tuple<walking::Command, double, double>{walking::Straight{0.6, 0}, 0, 0.03},
        {walking::TangentArc{0.75, 0.8}, 0.8, 0.04}}) {
    const Walked walked = walk(walk_of({command}), {});
    ASSERT_EQ(walked.status.condition, Condition::ok) << walked.status.cause;
    const double drift = (walked.X_PB.translation() - walked.planned.translation()).norm();
    EXPECT_LT(drift, most_m);
    EXPECT_GT(drift, 1e-5);  // only its feet move the robot
    EXPECT_NEAR(walking::yaw_of(walked.planned), turn, 1e-9);
    EXPECT_NEAR(walking::yaw_of(walked.X_PB), turn, 0.03);  // 4 sigma
  }
}

TEST(Walk, GoesTheSameWayFiftyMetersFromTheOrigin) {
  Eigen::Isometry3d far = Eigen::Isometry3d::Identity();
  far.translate(Eigen::Vector3d(50, -30, 0)).rotate(Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ()));
  const Walked here = walk(walk_of({walking::TangentArc{0.75, 0.6}}), {});
  const Walked there = walk(walk_of({walking::TangentArc{0.75, 0.6}}), {}, {}, {}, far);
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

using Eigen::Vector2d, Eigen::Vector3d;

Vector2d horizontal(const Eigen::Isometry3d& X) { return X.translation().head<2>(); }

TEST(Soles, PressEvenlyEnoughToResistYawAsAFlatSoleDoes) {
  World world = standing();
  run(world, 2000);
  const mjData* d = world.data();
  double load = 0, moment = 0;
  const Vector2d middle = (world.X_WL() * Vector3d(0.015, 0, 0)).head<2>();
  for (const mjContact* c = d->contact; c < d->contact + d->ncon; ++c) {
    const Vector2d place(c->pos[0], c->pos[1]);
    if (place.y() < 0) continue;  // of the right foot
    load += d->efc_force[c->efc_address];
    moment += d->efc_force[c->efc_address] * (place - middle).norm();
  }
  EXPECT_GT(load, 200);
  // Mean distance of the points of 0.230 x 0.138 m from their middle; only four corners: 0.134.
  EXPECT_NEAR(moment / load, 0.0717, 0.002);
}

TEST(Soles, CreepIsTheMotionOfAStandingFootBelowTheFrictionCone) {
  WorldOptions options;
  options.pushes = {{.time_s = 1, .impulse_ns = 60, .direction_rad = 0, .duration_s = 3}};  // 20 of 84 N
  World world = standing({}, Eigen::Isometry3d::Identity(), options);
  run(world, 1500);
  world.sole_contacts_since_last();
  const Vector2d before = horizontal(world.X_WL());
  run(world, 2000);
  const Vector2d moved = horizontal(world.X_WL()) - before;
  const SoleContact contact = world.sole_contacts_since_last()[0];
  EXPECT_GT(moved.x(), 1e-6);
  EXPECT_LT(moved.x(), 3e-4);  // a tenth of a millimetre a second
  // The push tilts the sole a little on its pads, which moves the point below the ankle too.
  EXPECT_NEAR(contact.creep.x(), moved.x(), 0.2 * moved.x());
  EXPECT_NEAR(contact.load, walking::hrp2::kMass * walking::kGravity / 2, 15);  // both feet alike
}

TEST(Soles, SlideWhereTheFloorIsSlippery) {
  WorldOptions options;
  options.pushes = {{.time_s = 0.5, .impulse_ns = 20, .direction_rad = 0, .duration_s = 1}};
  World dry = standing({}, Eigen::Isometry3d::Identity(), options);
  options.floor_patches = {{-1, 1, -1, 1, 0.02}};
  World wet = standing({}, Eigen::Isometry3d::Identity(), options);
  run(dry, 1500);
  run(wet, 1500);
  EXPECT_LT(dry.X_WL().translation().x() - 0.0095, 0.001);
  EXPECT_GT(wet.X_WL().translation().x() - 0.0095, 0.02);
}

TEST(Soles, StandOnTheFloorsHeight) {
  PlantVariation draw;
  draw.floor = {{0.004, Vector2d(0, 2), 0}};  // 4 mm cos(2 y): even in x
  World world = standing(draw);
  run(world, 1000);
  const double height = height_at(horizontal(world.X_WL()), draw.floor);
  EXPECT_GT(height, 0.0035);
  EXPECT_NEAR(world.X_WL().translation().z(), height, 0.001);  // the pads yield
}

TEST(Ground, OfSeveralPatchesTheLastOneCounts) {
  const std::vector<FloorPatch> patches{{0, 2, 0, 2, 0.3}, {1, 2, 0, 2, 0.4}};
  EXPECT_EQ(friction_at({-0.1, 1}, 0.7, patches), 0.7);
  EXPECT_EQ(friction_at({0.5, 1}, 0.7, patches), 0.3);
  EXPECT_EQ(friction_at({1.5, 1}, 0.7, patches), 0.4);
}

TEST(Push, GoesByTheHeadingOfTheWaist) {
  WorldOptions options;
  options.pushes = {{.time_s = 0.2, .impulse_ns = 10, .direction_rad = std::numbers::pi / 2}};
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.rotate(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ()));
  World world = standing({}, X_WB, options);
  run(world, 200);
  const Vector3d before = world.com();
  run(world, 100);
  const Vector3d moved = world.com() - before;
  // Heading 90 deg, push to the left of it: towards -x. Free, 10 Ns on 57 kg would be 9 mm in 0.1 s.
  EXPECT_LT(moved.x(), -0.003);
  EXPECT_GT(moved.x(), -0.009);
  EXPECT_LT(std::abs(moved.y()), 0.001);
}

}  // namespace
}  // namespace sim::physics
