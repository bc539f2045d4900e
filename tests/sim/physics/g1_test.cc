// Tests that the G1-like robot has its published weight and walks without force sensors at its ankles.
#include "sim/scenario/scenario.h"
#include "tests/sim/physics/test_worlds.h"

namespace sim::physics {
namespace {

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

/// Six steps with a push of 35 N for 0.2 s on one foot; the options are the robot's own.
Walked six_steps(const std::function<void(scenario::Scenario&)>& change = {}) {
  scenario::Scenario scenario =
      scenario::read_scenario(std::filesystem::path(GAITSLAM_SOURCE_DIR) / "scenarios/g1_tangent_circle.yaml")
          .scenario;
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
