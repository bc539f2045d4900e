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
  ASSERT_EQ(run("program", read(kWalk, {program()})).exit_code, 0);
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
      "world: {robot: g1, room: office_ramp}\nwalk: {commands: [{straight: {forward_m: 1.6}}]}\nlimits: {}\n";
  const auto level = run("level", read(kRamp, {program()}));
  EXPECT_EQ(level.ending, Ending::fell);
  EXPECT_THAT(level.cause,
              testing::MatchesRegex(".* deg, (at most .* % of|.* s at) a torque limit [(].*_joint[)], "
                                    "floor friction 0.70"));
  const auto outcome = run("slope", read(kRamp, {program(", options: {slope: true}")}));
  EXPECT_EQ(outcome.ending, Ending::completed) << outcome.cause;
  const sim::recording::RecordingReader level_reader(folder_ / "level" / "recording"),
      slope_reader(folder_ / "slope" / "recording");
  EXPECT_TRUE(level_reader.setup().calibration.level_floor);
  EXPECT_FALSE(slope_reader.setup().calibration.level_floor);
}

TEST_F(ControllerTest, AProgramRejectsInputOtherThanItsMessages) {
  const std::string command = fmt::format("echo 'a line of more than sixteen bytes' | '{}' walker 2>'{}'",
                                          GAITSLAM_PROGRAM, (folder_ / "said").string());
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 2);
  EXPECT_THAT(sim::files::read_text(folder_ / "said"), HasSubstr("not the messages of gaitslam"));
}

// A network with four hidden units: it sways with the sine of the phase and lifts each leg in its half of the
// phase. The recurrent network rotates its two-unit state without an input, and also turns its legs. The
// expected outputs of LSTM and GRU are from torch 1.13.1.
constexpr const char* kMakeNetwork = R"(
import numpy as np, subprocess, sys
joints = [f'{side}_{joint}_joint' for side in ('left', 'right')
          for joint in ('hip_pitch', 'hip_roll', 'hip_yaw', 'knee', 'ankle_pitch', 'ankle_roll')]
W0, b0, W1, b1 = np.zeros((4, 2)), np.array([0, 0, -3.5, -3.5]), np.zeros((12, 4)), np.zeros(12)
W0[0], W0[2, 0], W0[3, 0] = (0.088, 0.048), 6, -6
for side in (0, 1):
    for joint, share in ((0, -0.5), (3, 1), (4, -0.5)):
        W1[6 * side + joint, 2 + side] = b1[6 * side + joint] = 0.05 * share
    W1[6 * side + 1, 0], W1[6 * side + 5, 0] = 0.3, -0.3
np.savez(sys.argv[1], joints=joints, q0=np.radians([-21.55, 0, 0, 46.65, -25.1, 0] * 2), action_scale=1.0,
         kp=[4000, 4000, 4000, 4000, 1000, 1000] * 2, kd=[60, 60, 60, 60, 15, 15] * 2, rate_hz=50.0,
         settle_s=2.0, largest_speeds=[0.3, 0, 0.3], stands=True, phase_s=0.6, observations=['phase'],
         observation_scales=[1.0], W0=W0, b0=b0, W1=W1, b1=b1, activation='tanh')
turn, amplitude = 2 * np.pi * 0.02 / 0.64, 0.75
state = 1.2 * np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
plain = dict(np.load(sys.argv[1]))
gru = {'weight_ih_l0': np.zeros((6, 3)), 'weight_hh_l0': np.vstack([np.zeros((4, 2)), state]),
       'bias_ih_l0': [40, 40, -40, -40, 0.02, 0], 'bias_hh_l0': np.zeros(6)}
turns = W1.copy()
turns[2, 2] = turns[8, 3] = 0.04
recurrent = {**plain, **gru, 'stands': False, 'observations': ['command'], 'observation_scales': [0.0], 'W0': W0 / amplitude, 'W1': turns}
np.savez(sys.argv[2], **recurrent)

sys.path.insert(0, sys.argv[3])
import network_walker
def weights(*shape):
    return np.sin(1 + np.arange(np.prod(shape))).reshape(shape)
for gates, activation, expected in ((4, 'elu', [-0.5320223790, -0.1518338052]), (3, 'elu', [-0.5964973203, -0.3505637169]),
        (0, 'tanh', [-0.7615941560, 0.9640275801]), (0, 'relu', [0, 2]), (0, 'elu', [-0.6321205588, 2])):
    rows, size = 2 * gates, 3 if gates else 2
    cells = {'weight_ih_l0': weights(rows, 3), 'weight_hh_l0': weights(rows, 2),
             'bias_ih_l0': weights(rows), 'bias_hh_l0': weights(rows) / 2} if gates else {}
    network = network_walker.Network(network_walker.Arrays(
        cells, W0=np.eye(2), b0=np.zeros(2), W1=np.eye(2), b1=np.zeros(2), activation=activation), size, 2)
    outputs = [network(np.cos([t, t + 1, t + 2]) if gates else np.array([-1, 2])) for t in range(5)]
    np.testing.assert_allclose(outputs[-1], expected, atol=1e-9)
for name, value, message in (
        ('kp', None, 'missing array'), ('R0', state, 'unknown array'), ('kd', [1, 2], 'has shape (2,), expected (12,)'),
        ('q0', [np.nan] * 12, 'expected finite numbers'), ('joints', np.ones(12), 'expected text'),
        ('weight_hh_l0', np.ones((7, 2)), 'has shape (7, 2), expected (8, 2) or (6, 2)'),
        ('activation', 'gelu', 'unknown "gelu", expected any of tanh, relu, elu'),
        ('observations', ['gravity'], 'unknown "gravity", expected any of command, gyro, up, q, dq, action, phase')):
    np.savez('wrong.npz', **{key: array for key, array in {**recurrent, name: value}.items() if array is not None})
    made = subprocess.run([sys.executable, network_walker.__file__, 'wrong.npz'], capture_output=True, text=True)
    assert (made.returncode, made.stderr) == (2, f'wrong.npz: {name}: {message}\n'), made
)";

TEST_F(ControllerTest, NetworksOfTheExampleComputeLikePyTorchAndStandAndMarch) {
  const std::string plain = (folder_ / "plain.npz").string(),
                    recurrent = (folder_ / "recurrent.npz").string(), make = (folder_ / "make.py").string();
  sim::files::write_text(make, kMakeNetwork);
  ASSERT_EQ(std::system(fmt::format("cd '{}' && /usr/bin/python3 -B '{}' '{}' '{}' '{}/tools/examples'",
                                    folder_.string(), make, plain, recurrent, GAITSLAM_SOURCE_DIR)
                            .c_str()),
            0);
  constexpr const char* kG1 =
      "world: {robot: g1, room: floor}\nwalk: {commands: [{stand: {}}]}\nlimits: {}\n";
  const auto program = [](const std::string& network) {
    return fmt::format(
        "walk.controller={{program: [/usr/bin/python3, \"{}/tools/examples/network_walker.py\", \"{}\"]}}",
        GAITSLAM_SOURCE_DIR, network);
  };
  for (const auto& [name, network, command, least, most] :
       {std::tuple("stands", &plain, "{stand: {duration_s: 2}}", 0, 0),
        {"marches", &recurrent, "{straight: {forward_m: 1}}", 5, 12}}) {
    const auto outcome =
        run(name, read(kG1, {program(*network), fmt::format("walk.commands=[{}]", command)}));
    EXPECT_EQ(outcome.ending, Ending::completed) << outcome.cause;
    const sim::recording::Truth truth = sim::recording::read_truth(folder_ / name / "recording");
    const auto start = sim::recording::RecordingReader(folder_ / name / "recording").setup().X_WC_start;
    const Eigen::Isometry3d error = truth.camera.front().X.inverse() * start;
    EXPECT_LT(error.translation().norm(), 0.01) << name;
    EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 0.01) << name;
    const Eigen::Isometry3d turned = truth.waist.front().X;
    EXPECT_EQ(std::abs(std::atan2(turned(1, 0), turned(0, 0))) > 0.1, most > 0) << name;
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
  // The path waits for a robot that marches in place, but its end remains at the end of the commands.
  const auto outcome = run("steered", read(kG1, {program(recurrent), "walk.steering.by=truth",
                                                 "walk.commands=[{straight: {forward_m: 1}}]"}));
  EXPECT_EQ(outcome.ending, Ending::stopped) << outcome.cause;
  EXPECT_NEAR(score("steered", "navigation_end_position_error_m"), 1, 0.25);
}

}  // namespace
