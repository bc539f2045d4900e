#include "sim/scenario/scenario.h"
#include "tests/sim/physics/test_worlds.h"
#include "tests/walking/walks.h"

namespace sim::physics {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
const Eigen::Vector3d kDown(0, 0, -walking::kGravity);

Eigen::Matrix3d about_x(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()).toRotationMatrix();
}

ImuState tilted() {
  ImuState state;
  state.R_WG = about_x(0.3) * Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitY());
  state.v_WG = Eigen::Vector3d(0.4, -0.1, 0.05);
  return state;
}

TEST(Imu, MeasuresNothingOverAnEmptyInterval) {
  const ImuReading empty = reading_between({}, {}, kDown);
  EXPECT_EQ(empty.begin, empty.end);
  EXPECT_EQ(empty.specific_force, Eigen::Vector3d::Zero());
}

TEST(Imu, IntegratingAReadingLeadsFromOneStateToTheNext) {
  const ImuState from = tilted();
  ImuState to = from;
  to.t = walking::kTick;
  to.R_WG = from.R_WG * Eigen::AngleAxisd(0.004, Eigen::Vector3d(1, 2, -2) / 3.0).toRotationMatrix();
  to.v_WG += Eigen::Vector3d(0.01, 0.02, -0.015);
  const ImuReading reading = reading_between(from, to, kDown);
  const double dt = walking::kPeriod;
  const Eigen::Vector3d turn = reading.gyro * dt;
  const Eigen::Matrix3d R = from.R_WG * Eigen::AngleAxisd(turn.norm(), turn.normalized());
  const Eigen::Matrix3d R_amid = from.R_WG * Eigen::AngleAxisd(turn.norm() / 2, turn.normalized());
  const Eigen::Vector3d v = from.v_WG + dt * (R_amid * reading.specific_force + kDown);
  EXPECT_LT((R - to.R_WG).norm(), 1e-12);  // rounding of one Log and one Exp
  EXPECT_LT((v - to.v_WG).norm(), 1e-14);
}

TEST(World, BeginsWithTheSolesOnTheFloorWhereverTheWaistIs) {
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.translate(Eigen::Vector3d(50, -20, 3)).rotate(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ()));
  const World world = standing({}, X_WB);
  EXPECT_NEAR(world.X_WL().translation().z(), 0, 1e-9);
  EXPECT_NEAR(world.X_WR().translation().z(), 0, 1e-9);
  EXPECT_NEAR(world.X_WB().translation().x(), 50, 1e-12);
  EXPECT_NEAR(world.X_WB().translation().z(), on_floor().robot.base_height, 1e-9);
}

TEST(World, MeasuresItsWeightInTheFeetAndGravityInTheChestWhenStanding) {
  World world = standing();
  run(world, 3000);
  world.sensor_readings();
  run(world, 5);
  const walking::SensorReadings readings = world.sensor_readings();
  const double weight = on_floor().robot.mass * walking::kGravity;
  // The sole plates hang below the sensors.
  EXPECT_NEAR(readings.left.force.z() + readings.right.force.z(), weight, 2.0);
  EXPECT_NEAR(readings.accelerometer.norm(), walking::kGravity, 0.02);
  EXPECT_LT(readings.gyro.norm(), 0.01);
  // Center of pressure in x of the soles: under the center of mass.
  const double pressure_x = -(readings.left.torque.y() + readings.right.torque.y()) / weight;
  EXPECT_NEAR(pressure_x, world.com().x() - world.X_WL().translation().x(), 0.002);
}

TEST(World, ReadsJointsThroughTheirOffsets) {
  PlantVariation draw;
  draw.joint_offset_rad = Eigen::VectorXd::Constant(30, 0.002);
  World world = standing(draw);
  EXPECT_LT((world.sensor_readings().q - half_sitting()).norm(), 1e-12);
  EXPECT_GT((world.X_WC().linear() - standing().X_WC().linear()).norm(), 1e-3);
}

TEST(World, SplitsTheRecordedReadingsWithoutGapsAndWithoutDisturbingTheStabilizers) {
  World split = standing(), whole = standing();
  run(whole, 5);
  run(split, 3);
  const ImuReading first = split.imu_since_last();
  run(split, 2);
  const ImuReading second = split.imu_since_last();
  EXPECT_EQ(first.begin, 0ns);
  EXPECT_EQ(first.end, 3ms);
  EXPECT_EQ(second.begin, first.end);
  EXPECT_EQ(second.end, 5ms);
  EXPECT_EQ(split.sensor_readings().gyro, whole.sensor_readings().gyro);
}

/// Commands the half-sitting posture, with some joints at these angles.
void bend(World& world, std::initializer_list<std::pair<int, double>> joints) {
  walking::JointVector q = half_sitting();
  for (const auto& [joint, angle] : joints) q[joint] = angle;
  world.command({q, walking::JointVector::Zero(q.size())});
}

// Turns the chest steadily. Its velocity ripples within a tick if the target of its servo is held.
TEST(World, JointsMoveSteadilyWithinATick) {
  constexpr int kChest = 12;
  constexpr double kRate = 0.4;  // rad/s
  const auto ripple = [](bool moves) {
    World world = standing();
    walking::JointVector q = half_sitting(), dq = walking::JointVector::Zero(q.size());
    dq[kChest] = kRate;
    for (int tick = 0; tick < 40; ++tick) {
      q[kChest] += kRate * walking::kPeriod;
      world.command({q, dq, {}, moves});
      if (tick < 39) run(world, 5);
    }
    double lowest = 10, highest = 0, mean = 0;
    for (int ms = 0; ms < 5; ++ms) {
      run(world, 1);
      const double velocity = world.velocities()[kChest];
      lowest = std::min(lowest, velocity), highest = std::max(highest, velocity), mean += velocity / 5;
    }
    EXPECT_NEAR(mean, kRate, 0.002);
    return (highest - lowest) / kRate;
  };
  EXPECT_LT(ripple(true), 0.01);
  EXPECT_GT(ripple(false), 0.05);
}

// Feedback at half the rate of the commands must not shake the joints, for the desired velocity is a mean.
TEST(World, ADesiredVelocityThatAlternatesMovesNoJoint) {
  World world = standing();
  walking::JointVector dq = walking::JointVector::Zero(half_sitting().size());
  dq[12] = 0.4;  // rad/s, of the chest
  double fastest = 0;
  for (int tick = 0; tick < 40; ++tick) {
    world.command({half_sitting(), dq = -dq, {}, true});
    run(world, 5);
    if (tick >= 20) fastest = std::max(fastest, std::abs(world.velocities()[12]));
  }
  EXPECT_LT(fastest, 0.01);
}

TEST(World, EncodersTellWhereCameraAndImuAreWhileChestAndHeadMove) {
  World world = standing();
  bend(world, {{12, 0.1}, {15, 0.2}});
  run(world, 200);
  const World::Mounts mounts = world.mounts_by_encoders();
  EXPECT_TRUE((world.X_WB() * mounts.X_BC).isApprox(world.X_WC(), 1e-12));
  EXPECT_TRUE((world.X_WC() * mounts.X_CG).isApprox(world.X_WG(), 1e-12));
  EXPECT_FALSE(mounts.X_BC.isApprox(standing().mounts_by_encoders().X_BC, 0.01));
}

// Tests this while the chest turns and the head nods.
TEST(World, ReadingsOfAMovedImuAreInTheAxesOfTheChest) {
  rig::Mount turned, on_head;
  turned.yaw_rad = M_PI_2, turned.tilt_rad = 0.4;
  on_head.link = "HEAD_LINK1", on_head.roll_rad = M_PI;
  for (const rig::Mount& mount : {turned, on_head}) {
    Models moved(robot_file(), "floor", models());
    moved.mount({}, mount);
    World plain = standing(), world = standing(moved);
    for (World* each : {&plain, &world}) bend(*each, {{12, 0.1}, {15, 0.2}});
    for (int tick = 0; tick < 60; ++tick) {
      for (World* each : {&plain, &world}) run(*each, 5);
      const walking::SensorReadings expected = plain.sensor_readings(), found = world.sensor_readings();
      ASSERT_LT((found.gyro - expected.gyro).norm(), 1e-6) << mount.link << tick;
      if (mount.on_link()) continue;  // elsewhere the acceleration differs
      ASSERT_LT((found.accelerometer - expected.accelerometer).norm(), 1e-6) << tick;
    }
    EXPECT_LT((world.sensor_readings().accelerometer - plain.sensor_readings().accelerometer).norm(), 0.5);
  }
}

TEST(World, TheRobotKnowsWhereAMovedImuIs) {
  rig::Mount beside, on_head;
  beside.position_m = {0.1, -0.2, 0.3}, beside.yaw_rad = 1;
  on_head.link = "HEAD_LINK1", on_head.position_m = {0.05, 0, 0.1};
  const Eigen::Isometry3d before = walking::imu_in_base(on_floor().robot, on_floor().robot.posture);
  for (const rig::Mount& mount : {beside, on_head}) {
    Models moved(robot_file(), "floor", models());
    moved.mount({}, mount);
    const World world = standing(moved);
    const Eigen::Isometry3d X_BG = walking::imu_in_base(moved.robot, moved.robot.posture);
    EXPECT_LT((X_BG.translation() - (world.X_WB().inverse() * world.X_WG()).translation()).norm(), 1e-9);
    EXPECT_TRUE(X_BG.linear().isApprox(before.linear(), 1e-12));
    EXPECT_GT((X_BG.translation() - before.translation()).norm(), 0.3);
  }
}

/// The end is final: the physics stands still.
void expect_ended(World& world, Condition condition) {
  EXPECT_EQ(world.status().condition, condition) << world.status().cause;
  const auto when = world.time();
  run(world, 10);
  EXPECT_EQ(world.time(), when);
}

TEST(World, FeetThatTouchCollideUnlessAllowedTo) {
  World touching = standing(), brushing = standing();
  brushing.let_feet_touch();
  for (World* world : {&touching, &brushing}) {
    bend(*world, {{1, 0.25}, {7, -0.25}});  // both hips roll inwards
    run(*world, 500);
  }
  expect_ended(touching, Condition::collided);
  EXPECT_EQ(brushing.status().condition, Condition::ok) << brushing.status().cause;
}

TEST(World, ReportsTheDirectionOfThePushBeforeAFall) {
  World world = standing();
  world.start_clock(
      {{.time_s = 0.1, .impulse_ns = 90, .direction_rad = M_PI_2}, {.time_s = 60, .impulse_ns = 7}});
  run(world, 4000);
  expect_ended(world, Condition::fell);
  EXPECT_THAT(world.status().cause,
              testing::MatchesRegex("to the left at .* deg, [0-9.]+ s after the start of a push of 90 N s, "
                                    "floor friction [0-9.]+"));
}

/// Standing in the office with the waist at (x, y), heading along x.
World in_office(double x, double y) {
  return standing({}, Eigen::Isometry3d(Eigen::Translation3d(x, y, 0)), {}, "office");
}

// desk_1 is 0.8 m wide about x = 3.9 and ends at y = 1.97; the right hand hangs 0.33 m from the waist.
TEST(World, AHandThatBrushesADeskIsACollision) {
  World world = in_office(3.9, 2.4);
  run(world, 200);
  ASSERT_EQ(world.status().condition, Condition::ok) << world.status().cause;
  bend(world, {{17, -0.6}});  // the shoulder rolls outwards
  run(world, 1000);
  expect_ended(world, Condition::collided);
  EXPECT_THAT(world.status().cause, testing::MatchesRegex("RARM_LINK[3-6] touched desk_1 at .*"));
  EXPECT_GT(world.time(), 200ms);
}

TEST(World, ARobotPlacedInAnObjectHasCollidedFromTheBeginning) {
  World world = in_office(3.9, 1.2);
  world.step();
  EXPECT_EQ(world.status().condition, Condition::collided);
  EXPECT_THAT(world.status().cause, HasSubstr(" touched desk_1 at "));
}

TEST(World, EndsAsFailedWhenThePhysicsIsGivenNumbersThatAreNotFinite) {
  World world = standing();
  world.command({walking::JointVector::Constant(30, std::numeric_limits<double>::quiet_NaN()),
                 walking::JointVector::Zero(30)});
  run(world, 10);
  EXPECT_EQ(world.status().condition, Condition::physics_failed);
  EXPECT_FALSE(world.status().cause.empty());
}

TEST(World, EndsAsFailedOnAWarningOfMuJoCo) {
  Models models_on_floor(robot_file(), "floor", models());
  models_on_floor.on_floor->nconmax = 4;  // ten pads touch the floor
  World world = standing(models_on_floor);
  world.step();
  EXPECT_EQ(world.status().condition, Condition::physics_failed);
  EXPECT_THAT(world.status().cause, HasSubstr("contact"));
}

using walking::walk_of;

// HRP-2 itself drifts by one or two centimeters over 1 m, and by 0.1° (sd 0.7°) over twice this turn.
TEST(Walk, FollowsThePlanExceptForTheSlipOfItsFeet) {
  for (const auto& [command, turn, most_m] :
       {std::tuple<walking::Command, double, double>{walking::Straight{0.6, 0}, 0, 0.03},
        {walking::TangentArc{0.75, 0.8}, 0.8, 0.04}}) {
    const Walked walked =
        walk({walking::PatternGenerator(on_floor().robot, walk_of({command})), {}, {}, {}, on_floor()});
    ASSERT_EQ(walked.status.condition, Condition::ok) << walked.status.cause;
    const double drift = (walked.X_PB.translation() - walked.planned.translation()).norm();
    EXPECT_LT(drift, most_m);
    EXPECT_GT(drift, 1e-5);  // only its feet move the robot
    EXPECT_NEAR(walking::yaw_of(walked.planned), turn, 1e-9);
    EXPECT_NEAR(walking::yaw_of(walked.X_PB), turn, 0.03);  // 4 sigma
  }
}

TEST(Walk, LegOdometryKnowsTheTiltOfTheSolesOnTheirPadsAndTheLagOfTheBushes) {
  const Models on_floor(robot_file(), "floor", models());
  WalkingRobot robot(walking::PatternGenerator(on_floor.robot, walk_of({walking::TangentArc{0.75, 0.6}})), {},
                     {}, {}, on_floor);
  walking::Robot rigid = on_floor.robot;
  for (walking::Leg& leg : rigid.legs) leg.pad_stiffness.setConstant(1e9);
  walking::Robot undamped = on_floor.robot;
  for (walking::Leg& leg : undamped.legs)
    for (walking::Spring& spring : leg.bush) spring.lag_s = 0;
  const Eigen::Isometry3d X_WB = robot.world().X_WB();
  walking::LegOdometry whole(on_floor.robot, X_WB), without_pads(rigid, X_WB), without_lag(undamped, X_WB);
  double tilt = 0, tilt_without_pads = 0, tilt_without_lag = 0;  // sums of squares
  while (robot.walks()) {
    robot.tick();
    const walking::SensorReadings readings = robot.world().leg_readings();
    const auto add = [&](walking::LegOdometry& legs, double& sum) {
      legs.add(readings);
      const Eigen::Matrix3d R_OB = legs.motion(readings.q).X_OB.linear();
      sum += (R_OB.row(2) - robot.world().X_WB().linear().row(2)).squaredNorm();
    };
    add(whole, tilt), add(without_pads, tilt_without_pads), add(without_lag, tilt_without_lag);
  }
  EXPECT_LT(tilt, 0.5 * tilt_without_pads);
  EXPECT_LT(tilt, 0.5 * tilt_without_lag);
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
    if (place.y() < 0) continue;  // pads of the right foot
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
  EXPECT_LT(moved.x(), 3e-4);  // a tenth of a millimeter per second
  // The push tilts the sole a little on its pads, which moves the point below the ankle too.
  EXPECT_NEAR(contact.creep.x(), moved.x(), 0.2 * moved.x());
  EXPECT_NEAR(contact.load, on_floor().robot.mass * walking::kGravity / 2, 15);  // both feet alike
}

TEST(Soles, SlideWhereTheFloorIsSlippery) {
  WorldOptions options;
  options.pushes = {{.time_s = 0.5, .impulse_ns = 20, .direction_rad = 0, .duration_s = 1}};
  World dry = standing({}, Eigen::Isometry3d::Identity(), options);
  options.floor_patches = {{-1, 1, -1, 1, 0.02}};
  World wet = standing({}, Eigen::Isometry3d::Identity(), options);
  for (World* world : {&dry, &wet}) run(*world, 1500);
  EXPECT_LT(dry.X_WL().translation().x() - 0.0095, 0.001);
  EXPECT_GT(wet.X_WL().translation().x() - 0.0095, 0.02);
}

// On a floor at -0.3 m, the waist of a standing robot is as low as a fallen robot's on a floor at z = 0.
TEST(World, StandsOnTheRoomsOwnFloorWithItsFrictionWhereverThatIs) {
  const files::TemporaryFolder folder;
  files::write_text(
      folder / "low.xml",
      "<mujoco><default><default class='floor'><geom friction='0.5 0.005 0.0001'/></default>"
      "</default><worldbody><geom name='hall' type='plane' size='9 9 1' class='floor' "
      "pos='0 0 -0.3'/><geom name='mat' class='floor' type='box' size='1 1 0.01' pos='2 0 -0.3'/>"
      "</worldbody></mujoco>");
  const std::string room = (folder / "low.xml").string();
  World world = standing({}, Eigen::Isometry3d::Identity(), {}, room.c_str());
  run(world, 500);
  EXPECT_EQ(world.status().condition, Condition::ok) << world.status().cause;
  EXPECT_NEAR(world.X_WL().translation().z(), -0.3, 0.01);
  const int pad =
      contacts(*world.model(), world.model()->site_bodyid[part(*world.model(), mjOBJ_SITE, "left_sole")])[0];
  EXPECT_NEAR(world.model()->geom_friction[3 * pad], 0.5 * kFloorFriction, 1e-12);
  const Floor floor(*world.model());
  EXPECT_NEAR(floor.height(*world.data(), {2, 0}), -0.29, 1e-9);
  EXPECT_EQ(floor.solids(), 1u);
}

TEST(Soles, StandAtTheHeightOfTheFloor) {
  PlantVariation draw;
  draw.floor = {{0.004, Vector2d(0, 2), 0}};  // 4 mm cos(2 y): even in x
  World world = standing(draw);
  run(world, 1000);
  const double height = height_at(horizontal(world.X_WL()), draw.floor);
  EXPECT_GT(height, 0.0035);
  EXPECT_NEAR(world.X_WL().translation().z(), height, 0.001);  // the pads yield
}

TEST(Ground, TheLastOfSeveralPatchesCounts) {
  const std::vector<FloorPatch> patches{{0, 2, 0, 2, 0.3}, {1, 2, 0, 2, 0.4}};
  EXPECT_EQ(friction_at({-0.1, 1}, 0.7, patches), 0.7);
  EXPECT_EQ(friction_at({0.5, 1}, 0.7, patches), 0.3);
  EXPECT_EQ(friction_at({1.5, 1}, 0.7, patches), 0.4);
}

TEST(Push, IsRelativeToTheHeadingOfTheWaist) {
  WorldOptions options;
  options.pushes = {{.time_s = 0.2, .impulse_ns = 10, .direction_rad = std::numbers::pi / 2}};
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.rotate(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ()));
  World world = standing({}, X_WB, options);
  run(world, 200);
  const Vector3d before = world.com();
  run(world, 100);
  const Vector3d moved = world.com() - before;
  // Heading 90 deg, push to the left of it: toward -x. Free, 10 Ns on 57 kg would be 9 mm in 0.1 s.
  EXPECT_LT(moved.x(), -0.003);
  EXPECT_GT(moved.x(), -0.009);
  EXPECT_LT(std::abs(moved.y()), 0.001);
}

const Models& g1() {
  static const Models models_of_g1(robot_file("g1"), "floor", models());
  return models_of_g1;
}

PlantVariation on_friction(double friction) {
  PlantVariation draw;
  draw.floor_friction = friction;
  return draw;
}

World standing_g1() {
  return standing(g1(), on_friction(0.7),
                  Eigen::Isometry3d(Eigen::Translation3d(0, 0, g1().robot.base_height)));
}

// The stabilizer's feedback must not excite HRP-2's legs on their rubber bushes.
TEST(Walk, ARobotThatStandsIsAtRest) {
  WalkingRobot robot(walking::PatternGenerator(on_floor().robot, walk_of({walking::Stand{1}})), {}, {},
                     on_friction(0.7), on_floor());
  while (robot.walks()) robot.tick();
  const walking::JointVector torques = robot.world().torques();
  robot.tick();
  EXPECT_LT((robot.world().torques() - torques).cwiseAbs().maxCoeff(), 0.5) << "N m in 5 ms";
}

/// Six steps with a push of 35 N for 0.2 s on one foot; the options are the robot's own.
Walked six_steps(const std::function<void(scenario::Scenario&)>& change = {}) {
  scenario::Scenario scenario =
      scenario::read_scenario(fs::path(GAITSLAM_SOURCE_DIR) / "scenarios/g1_tangent_circle.yaml").scenario;
  const walking::Step left{0.05, 0.237, 0}, right{0.05, -0.237, 0};
  scenario.walk.commands = {walking::Stand{1}, walking::Steps{{left, right, left, right, left, right}}};
  scenario.world.pushes = {{.time_s = 2.2, .impulse_ns = 7, .direction_rad = 1.2, .duration_s = 0.2}};
  if (change) change(scenario);
  return walk({walking::PatternGenerator(g1().robot, scenario.walk), scenario.stabilizer, scenario.world,
               on_friction(scenario.world.floor_friction), g1()});
}

TEST(G1, SurvivesAPushButOnlyWithStabilizerAndAdjustedLandings) {
  const Walked walked = six_steps();
  EXPECT_EQ(walked.status.condition, Condition::ok) << walked.status.cause;
  EXPECT_LT((walked.X_PB.translation() - walked.planned.translation()).norm(), 0.03);
  const std::vector<std::function<void(scenario::Scenario&)>> changes{
      [](scenario::Scenario& s) { s.stabilizer.enabled = false; },
      [](scenario::Scenario& s) { s.stabilizer.landing_adjustment.enabled = false; }};
  for (const auto& change : changes) EXPECT_EQ(six_steps(change).status.condition, Condition::fell);
}

TEST(G1, MeasuresItsWeightByTheTorquesOfItsLegs) {
  World world = standing_g1();
  for (int k = 0; k < 300; ++k) world.step();
  const walking::SensorReadings readings = world.leg_readings();
  EXPECT_NEAR(g1().robot.mass, 33.341, 0.001) << "as published";
  const double weight = g1().robot.mass * walking::kGravity;
  // It is still sinking onto its pads and springs, so its weight is within 5 % of its weight at rest.
  EXPECT_NEAR(readings.left.force.z() + readings.right.force.z(), weight, 0.05 * weight);
  EXPECT_NEAR(readings.left.force.z(), readings.right.force.z(), 0.1 * weight);
}

TEST(G1, ServosWithoutStiffnessOnlyDampAtEachCommandAnew) {
  RobotFile file = robot_file("g1");
  for (RobotFile::Servo& servo : file.servos) servo.kp_nm_rad = 0, servo.kd_nms_rad = 2;
  World world = standing(Models(file, "floor", models()));
  const walking::JointVector& q = g1().robot.posture;
  for (int k = 0; k < 2; ++k) world.command({q, walking::JointVector::Constant(q.size(), 0.5)});
  EXPECT_EQ(world.data()->qfrc_applied[6], 1) << "torque of the joint after the base";
}

TEST(G1, ATorqueNeverExceedsItsLimitAndIsReportedWhenItReachesIt) {
  World world = standing_g1();
  world.step();
  world.torque_limited_since_last();
  world.step();
  EXPECT_EQ(world.torque_limited_since_last(), std::optional(false));
  walking::JointVector bent = g1().robot.posture;
  const int knee = g1().robot.leg(walking::Side::left).joints[3];
  bent[knee] += 1;  // 4000 N·m by the servo's stiffness
  world.command({bent, walking::JointVector::Zero(bent.size())});
  world.step();
  EXPECT_EQ(world.torque_limited_since_last(), std::optional(true));
  const mjModel& m = *world.model();
  const int dof = m.jnt_dofadr[m.actuator_trnid[2 * knee]];
  const double torque = world.data()->actuator_force[knee];
  EXPECT_NEAR(torque, 139, 0.02 * 139 + m.dof_damping[dof] * std::abs(world.data()->qvel[dof]));
  EXPECT_EQ(on_floor().robot.joints[0].effort, std::numeric_limits<double>::infinity());
  EXPECT_EQ(standing().torque_limited_since_last(), std::nullopt);  // HRP-2's limits are not published
}

}  // namespace
}  // namespace sim::physics
