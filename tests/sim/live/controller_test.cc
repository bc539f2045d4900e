// Walks by external controllers.
#include "sim/recording/recording.h"
#include "tests/sim/live/run_folder.h"

namespace {

using sim::scenario::Ending;
using testing::AllOf, testing::HasSubstr, testing::Not;

constexpr const char* kWalk = R"(
walk: {commands: [{stand: {duration_s: 0.2}}, {tangent_arc: {radius_m: 0.75, angle_deg: 5}}]}
camera: {width_px: 160, height_px: 120}
slam: {}
limits: {ending: [completed]}
)";

class ControllerTest : public tests::RunFolder {
 protected:
  static std::string program(const std::string& options = "") {
    return fmt::format("walk.controller={{program: [\"{}\", walker]{}}}", GAITSLAM_PROGRAM, options);
  }
};

TEST_F(ControllerTest, TheBuiltInControllerGivesTheSameBytesAsAProgram) {
  ASSERT_EQ(run("inside", read(kWalk)).exit_code, 0);
  // A program that plans its own steps walks as planned, although robots steer by their legs by default.
  ASSERT_EQ(run("program", read(kWalk, {program(), "walk.steering.by=legs"})).exit_code, 0);
  const auto differ = tests::differences(folder_ / "inside", folder_ / "program");
  EXPECT_THAT(differ, testing::IsSubsetOf({"about.json", "scenario.yaml", "score.json",  // they name it
                                           "recording/controller.json", "recording/manifest.csv"}));
  EXPECT_THAT(file("program", "recording/controller.json"), HasSubstr("\"answers\": "));
  EXPECT_FALSE(file("program", "estimate.tum").empty());
  const std::string torques = file("program", "recording/truth/torques.csv");
  EXPECT_EQ(std::ranges::count(torques, '\n'),
            std::ranges::count(file("program", "recording/truth/feet.csv"), '\n'));
  EXPECT_THAT(torques, HasSubstr(",LLEG_JOINT3 [N m],"));
}

TEST_F(ControllerTest, AProgramThatFailsEndsTheWalkAsWalkerFailed) {
  for (const auto& [name, after] : {std::pair("settling", 0), {"walking", 20}}) {
    const auto outcome = run(
        name,
        read(kWalk, {fmt::format("walk.controller={{program: [\"{}\"], options: {{fault: exit, after: {}}}}}",
                                 GAITSLAM_FAULTY_WALKER, after)}));
    EXPECT_EQ(outcome.ending, Ending::walker_failed);
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_THAT(outcome.cause, HasSubstr("its last lines: loading | the policy is broken")) << name;
    EXPECT_EQ(file(name, "controller.log"), "loading\nthe policy is broken\n");
  }
}

TEST_F(ControllerTest, AProgramReceivesTheWalkWithoutTheWorld) {
  const std::string start = (folder_ / "start").string();
  EXPECT_THROW(
      run("start",
          read(kWalk, {fmt::format("walk.controller={{program: [sed, '-n', '/<mujoco/q; w {}']}}", start)})),
      std::invalid_argument);
  EXPECT_THAT(sim::files::read_text(start),
              AllOf(HasSubstr("tangent_arc: {radius_m: 0.75"), HasSubstr("robot: hrp2"),
                    Not(HasSubstr("floor_friction"))));
}

TEST_F(ControllerTest, TheBuiltInControllerWalksOntoARampUsingTheSlopeOfItsSoles) {
  constexpr const char* kRamp =
      "seed: 2\nworld: {robot: g1, room: office_ramp}\nwalk: {commands: [{straight: {forward_m: "
      "1.6}}]}\nlimits: {}\n";
  const auto level = run("level", read(kRamp, {program()}));
  EXPECT_EQ(level.ending, Ending::fell);
  EXPECT_THAT(level.cause,
              testing::MatchesRegex(".* deg, (at most .* % of|.* s at) a torque limit [(].*_joint[)], "
                                    "floor friction 0.69"));
  const auto outcome = run("slope", read(kRamp, {program(", options: {slope: true}")}));
  EXPECT_EQ(outcome.ending, Ending::completed) << outcome.cause;
  const sim::recording::RecordingReader level_reader(folder_ / "level" / "recording"),
      slope_reader(folder_ / "slope" / "recording");
  EXPECT_TRUE(level_reader.setup().calibration.level_floor);
  EXPECT_FALSE(slope_reader.setup().calibration.level_floor);
}

// 8 degrees make the robot fall, and so do 3 cm.
TEST_F(ControllerTest, AFootstepThatIsTooSteepForAControllerThatFollowsSlopesIsAnError) {
  const auto on = [&](const std::string& geom) {
    sim::files::write_text(folder_ / "edge.xml",
                           "<mujoco><include file='" GAITSLAM_SOURCE_DIR
                           "/models/office.xml'/><worldbody><geom class='floor' type='box' " +
                               geom + "/></worldbody></mujoco>");
    const std::string scenario = fmt::format(
        "world: {{robot: g1, room: {}/edge.xml}}\nwalk: {{commands: [{{straight: {{forward_m: "
        "1}}}}]}}\nlimits: "
        "{{}}\n",
        folder_.string());
    return sim::files::error_of(
        [&] { sim::live::check(read(scenario.c_str(), {program(", options: {slope: true}")}), kModels); });
  };
  EXPECT_EQ(on("size='0.5 1 0.05' pos='1 0 -0.045' euler='0 -5 0'"), "");
  for (const char* geom :
       {"size='0.5 1 0.05' pos='1 0 -0.02' euler='0 -8 0'", "size='0.5 1 0.015' pos='1 0 0.015'"})
    EXPECT_THAT(on(geom), HasSubstr("expected slopes of at most 7.5 deg and edges of at most 0.02 m"));
}

TEST_F(ControllerTest, AProgramRejectsInputOtherThanItsMessages) {
  const std::string command = fmt::format("echo 'a line of more than sixteen bytes' | '{}' walker 2>'{}'",
                                          GAITSLAM_PROGRAM, (folder_ / "said").string());
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 2);
  EXPECT_THAT(sim::files::read_text(folder_ / "said"), HasSubstr("not the messages of gaitslam"));
}

// A network with four hidden units: it sways with the sine of the phase and lifts each leg in its half of the
// phase. It also turns the lifted leg. It stands if the phase is 0 at a zero command.
constexpr const char* kMakeNetwork = R"(
import numpy as np, onnx, onnx.numpy_helper
from onnx import TensorProto, helper
W0, b0, W1, b1 = np.zeros((4, 2)), np.array([0, 0, -3.5, -3.5]), np.zeros((12, 4)), np.zeros(12)
W0[0], W0[2, 0], W0[3, 0] = (0.088, 0.048), 6, -6
for side in (0, 1):
    for joint, share in ((0, -0.5), (3, 1), (4, -0.5)):
        W1[6 * side + joint, 2 + side] = b1[6 * side + joint] = 0.05 * share
    W1[6 * side + 1, 0], W1[6 * side + 5, 0] = 0.3, -0.3
    W1[6 * side + 2, 2 + side] = b1[6 * side + 2] = 0.05
nodes = [helper.make_node('Gemm', ['obs', 'W0', 'b0'], ['x'], transB=1), helper.make_node('Tanh', ['x'], ['h']),
         helper.make_node('Gemm', ['h', 'W1', 'b1'], ['actions'], transB=1)]
obs, actions = (helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, n]) for name, n in (('obs', 2), ('actions', 12)))
onnx.save(helper.make_model(helper.make_graph(nodes, 'sway', [obs], [actions], [
    onnx.numpy_helper.from_array(array, name) for name, array in (('W0', W0), ('b0', b0), ('W1', W1), ('b1', b1))])), 'sway.onnx')
for name, rest, gain in (('stands', 'at_rest: 0', 1), ('marches', '', 1), ('limp', '', 0.001)):
    open(f'{name}.yaml', 'w').write(f"""
joints: {[f'{side}_{joint}_joint' for side in ('left', 'right')
          for joint in ('hip_pitch', 'hip_roll', 'hip_yaw', 'knee', 'ankle_pitch', 'ankle_roll')]}
step_dt: 0.02
stands: {str(bool(rest)).lower()}
stiffness: {[gain * kp for kp in [4000, 4000, 4000, 4000, 1000, 1000] * 2]}
damping: {[60, 60, 60, 60, 15, 15] * 2}
default_joint_pos: {np.radians([-21.55, 0, 0, 46.65, -25.1, 0] * 2).tolist()}
commands: {{base_velocity: {{ranges: {{lin_vel_x: [-0.3, 0.3], lin_vel_y: 0, ang_vel_z: [-0.3, 0.3]}}}}}}
observations: {{gait_phase: {{params: {{period: 0.64, {rest}}}}}}}
""")
)";

TEST_F(ControllerTest, APolicyOfTheExampleStandsOrMarches) {
  sim::files::write_text(folder_ / "make.py", kMakeNetwork);
  ASSERT_EQ(std::system(fmt::format("cd '{}' && /usr/bin/python3 make.py", folder_.string()).c_str()), 0);
  constexpr const char* kG1 =
      "world: {robot: g1, room: floor}\nwalk: {commands: [{stand: {}}]}\nlimits: {}\n";
  const auto program = [this](const std::string& policy) {
    return fmt::format(
        "walk.controller={{program: [/usr/bin/python3, \"{0}/tools/examples/network_walker.py\", "
        "\"{1}/{2}.yaml\", "
        "\"{1}/sway.onnx\"]}}",
        GAITSLAM_SOURCE_DIR, folder_.string(), policy);
  };
  for (const auto& [name, command, least, most] : {std::tuple("stands", "{stand: {duration_s: 2}}", 0, 0),
                                                   {"marches", "{straight: {forward_m: 1}}", 5, 12}}) {
    const auto outcome = run(name, read(kG1, {program(name), fmt::format("walk.commands=[{}]", command)}));
    EXPECT_EQ(outcome.ending, Ending::completed) << outcome.cause;
    const sim::recording::Truth truth = sim::recording::read_truth(folder_ / name / "recording");
    const auto start = sim::recording::RecordingReader(folder_ / name / "recording").setup().X_WC_start;
    const Eigen::Isometry3d error = truth.camera.front().X.inverse() * start;
    EXPECT_LT(error.translation().norm(), 0.01) << name;
    EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 0.01) << name;
    const Eigen::Isometry3d turned = truth.waist.front().X;
    EXPECT_EQ(std::abs(std::atan2(turned(1, 0), turned(0, 0))) > 0.03, most > 0) << name;
    EXPECT_LT((truth.waist_desired.front().X.inverse() * turned).translation().head<2>().norm(), 1e-3)
        << name;
    int lifts = 0;  // number of lifts of the left foot
    bool was_up = false;
    for (const sim::recording::TrueFeet& feet : truth.feet) {
      const bool up = feet.left.load_n < 5;
      lifts += up && !std::exchange(was_up, up);
      was_up = up;
    }
    EXPECT_GE(lifts, least) << name;
    EXPECT_LE(lifts, most) << name;
    EXPECT_THAT(file(name, "score.json"), HasSubstr("the walk has no plan"));
    EXPECT_THAT(file(name, "feet.csv"), AllOf(HasSubstr(",left,support,"), Not(HasSubstr("put_down"))));
  }
  const auto limp = run("limp", read(kG1, {program("limp")}));
  EXPECT_EQ(limp.ending, Ending::fell);
  EXPECT_THAT(limp.cause, HasSubstr(" s of settling: the waist is"));
  EXPECT_THAT(file("limp", "truth.tum"), testing::IsEmpty());
  // The path waits for a robot that marches in place, but its end remains at the end of the commands.
  const auto outcome = run("steered", read(kG1, {program("marches"), "walk.steering.by=truth",
                                                 "walk.commands=[{straight: {forward_m: 1}}]"}));
  EXPECT_EQ(outcome.ending, Ending::stopped) << outcome.cause;
  EXPECT_NEAR(score("steered", "navigation_end_position_error_m"), 1, 0.25);
}

}  // namespace
