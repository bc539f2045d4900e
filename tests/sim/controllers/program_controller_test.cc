// External walking controllers: their input, and the handling of faulty ones.
#include "sim/controllers/program_controller.h"

#include "tests/sim/files/temporary_folder.h"

namespace sim::controllers {
namespace {

using files::error_of, testing::HasSubstr, testing::StartsWith;

/// A robot with two joints.
walking::Robot robot() {
  walking::Robot robot;
  for (const char* name : {"left_knee", "right_knee"}) {
    walking::Joint& joint = robot.joints.emplace_back();
    joint.name = name, joint.lowest = -0.1, joint.highest = 2;
  }
  for (walking::Leg& leg : robot.legs) leg.joints = {0, 0, 0, 0, 0, 1};
  robot.posture = Eigen::Vector2d(0.5, 0.6);
  return robot;
}

ProgramStart with_fault(const std::string& fault,
                        std::vector<walking::Command> commands = {walking::Straight{}}) {
  ProgramStart start;
  start.choice = {programs::Source::program, "faulty", {GAITSLAM_FAULTY_WALKER}, {{"fault", fault}}, 60, 0.3};
  start.robot = robot();
  start.description.motors.resize(2, {0, 0, 50, 1});
  start.commands.commands = std::move(commands);
  return start;
}

Readings readings() {
  Readings at_rest;
  at_rest.accelerometer.z() = walking::kGravity;
  at_rest.q = robot().posture;
  at_rest.dq = at_rest.torque = Eigen::Vector2d::Zero();
  return at_rest;
}

/// Walks for some ticks and returns the commands of the last one.
JointCommands walk(ProgramController& controller, int ticks) {
  JointCommands last;
  for (int i = 0; i < ticks; ++i) last = controller.command(readings(), false), controller.advance();
  return last;
}

TEST(ProgramController, AFaultIsReportedWithItsCauseAndAtAStepWithTimeAndLastLines) {
  for (const auto& row : tests::rows_of("sim/controllers/faults.txt")) {
    std::string start, step;
    start = error_of<std::invalid_argument>([&] {
      ProgramController controller(with_fault(row.at(1)));
      walk(controller, 4);  // 100 Hz: every second tick
      step = error_of<programs::ProgramFailed>([&] { walk(controller, 1); });
    });
    const bool at_start = row[0] == "start";
    EXPECT_THAT(at_start ? start : step, HasSubstr(row.at(2)));
    EXPECT_THAT(at_start ? start : step,
                StartsWith(at_start ? "walking controller: faulty: "
                                    : "the walking controller faulty failed at t = 0.020 s: "));
  }
}

TEST(ProgramController, ACommandThatItCannotFollowIsAnInputError) {
  const auto rejection = [](const ProgramStart& start) {
    return error_of<std::invalid_argument>([&] { ProgramController unused(start); });
  };
  EXPECT_THROW(ProgramController(with_fault("dies_at_start")), programs::ProgramFailed);
  for (const walking::Command& impossible :
       std::vector<walking::Command>{walking::Straight{0, 1}, walking::Steps{}})
    EXPECT_THAT(rejection(with_fault("none", {impossible})), StartsWith("walk.commands[0]"));
}

TEST(ProgramController, CommandsServosAtItsRateAndClipsAngles) {
  ProgramController controller(with_fault("clips"));
  const JointCommands commands = walk(controller, 1);
  EXPECT_EQ(commands.q, Eigen::Vector2d(2, 0.6)) << "clipped to its range";
  EXPECT_EQ(controller.clipped(), 1U);
  EXPECT_EQ(commands.gains->kp, Eigen::Vector2d(100, 100));
  walk(controller, 2);
  EXPECT_EQ(controller.clipped(), 2U) << "requested at ticks 0 and 2";
  EXPECT_THAT(controller.finish(), StartsWith("gaitslam: 2 of 4 commanded angles were beyond the range"));
}

TEST(ProgramController, AnExitCodeAfterEndIsLogged) {
  EXPECT_EQ(ProgramController(with_fault("late")).finish(),
            "gaitslam: after END, it ended with exit code 7\n");
  EXPECT_EQ(ProgramController(with_fault("none")).finish(), "");
}

// The answer is the velocity, place or number of bytes that the program received, as a torque.
TEST(ProgramController, AProgramReceivesVelocityByTheLegsPlaceAndRig) {
  ProgramStart start = with_fault("echoes");
  start.commands.steering.by = walking::SteeredBy::estimate;
  ProgramController controller(start);
  walk(controller, 6);
  controller.steer(6,
                   walking::PlaceEstimate{0.0175, {{0, 0}, 0}, {{3, 4}, 0.5}, Eigen::Matrix3d::Identity()});
  controller.add_rig("12345678");
  const Eigen::VectorXd place = walk(controller, 1).gains->torque;
  EXPECT_NEAR(place[0], 3, 0.02) << "and half a millimeter per tick along the path";
  EXPECT_EQ(place[1], 8);
  EXPECT_EQ(walk(controller, 2).gains->torque[1], 0) << "each message is sent once";
}

// Its largest speed is 0.5 m/s, so that half a step is 0.1 m.
TEST(ProgramController, ASteeredCommandEndsUpToHalfAStepFromItsEnd) {
  const auto ends = [](double error_m) {
    ProgramStart start = with_fault("none");
    start.commands.steering.by = walking::SteeredBy::truth;
    ProgramController controller(start);
    for (std::size_t tick = 0; tick < 1000; ++tick) {
      walk(controller, 1);
      const walking::FootPose planned = walking::on_floor(controller.following().X_PB);
      controller.steer(tick, walking::PlaceEstimate{double(tick) * walking::kPeriod, planned,
                                                    planned * walking::FootPose{{-error_m, 0}, 0}});
    }
    return !controller.walks();
  };
  EXPECT_TRUE(ends(0.09));
  EXPECT_FALSE(ends(0.11));
}

TEST(ProgramController, ItsOwnPlanTellsWhereItIsOnThePath) {
  ProgramController controller(with_fault("stays"));
  int ticks = 0;
  for (; !controller.stopped() && ticks < 10000; ++ticks) walk(controller, 1);
  EXPECT_THAT(controller.stopped().value_or(""),
              HasSubstr("took more than 2 times its 2.5 s: the base is 0.30"));
}

TEST(ProgramController, AnAnswerTakesEffectAfterItsComputingTime) {
  for (const auto& [time_s, effects] : {std::pair{0.012, std::vector{0, 0, 0, 1}},  // at the tick of 15 ms
                                        {0.01, {0, 0, 1, 1, 2, 2}}}) {  // before the next sensors, not busy
    ProgramStart start = with_fault("clips");
    start.time.fixed_s = time_s;
    ProgramController controller(start);
    for (const int clipped : effects) {
      walk(controller, 1);
      EXPECT_EQ(controller.clipped(), static_cast<std::size_t>(clipped)) << time_s;
    }
  }
}

}  // namespace
}  // namespace sim::controllers
