// The command line, without simulations.
#include <regex>
#include <sstream>
#include <tuple>

#include "tests/tools/command_line.h"

namespace tests {
namespace {

using Cli = CommandLine;

TEST_F(Cli, HelpOfTheProgramAndOfEachCommandHasExamples) {
  for (const std::string command : {"", "run ", "replay ", "export ", "score ", "sweep ", "tune ", "regress ",
                                    "compare ", "evaluate ", "baseline update ", "check ", "config "}) {
    const std::string help = ok(command + "--help");
    EXPECT_THAT(help, Has("\nUsage: gaitslam ", "Examples:\n  gaitslam " + command));
    std::istringstream lines(help);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100U) << help;
  }
  EXPECT_THAT(ok("--version"), AllOf(Has("(revision ", "Eigen 3.", "OpenCV 4."), StartsWith("gaitslam ")));
  EXPECT_THAT(ok("config --keys"),
              Has("slam.gyro.sigma_rad_s\n    assumed standard deviation", "ate_se3_rmse_m"));
}

TEST_F(Cli, HelpPrintsThePageOfACommandAndTopicsFromTheReadmes) {
  EXPECT_EQ(ok("help run"), ok("run --help"));
  std::istringstream topics("cache ci controller estimator exit-codes formats scenario slurm");
  for (std::string topic; topics >> topic;) {
    EXPECT_THAT(ok("help"), Has(topic));
    EXPECT_THAT(ok("help " + topic), StartsWith("#"));
  }
  EXPECT_THAT(ok("help slurm"), AllOf(Has("SBATCH_PARTITION"), Lacks("\n## ")));
  EXPECT_THAT(refusal("help slrum"), Has("is 'slrum', expected a command or one of the topics cache, ci"));
}

// Loading 120 libraries and a compiler would cost each process 90 ms.
TEST_F(Cli, CodecsAndOpenGLAreNotLoadedBeforeTheyAreNeeded) {
  const std::string loaded = shell("LD_TRACE_LOADED_OBJECTS=1 " GAITSLAM_PROGRAM).out;
  ASSERT_THAT(loaded, Has("libopencv_core"));
  for (const char* library : {"libopencv_imgcodecs", "libgdal", "libOSMesa", "libLLVM"})
    EXPECT_THAT(loaded, Lacks(library));
}

// Uses a source tree with stand-ins for both programs.
TEST_F(Cli, TheLauncherBuildsTheRunnerForItsCommandsAndTheWholeProgramForTheRestAndTheView) {
  write("tools/gaitslam", sim::files::read_text(kSources + "/tools/gaitslam"));
  for (const char* source : {"CMakeLists.txt", "CMakePresets.json", "walking/x", "slam/x", "sim/x"})
    write(source, "");
  write("build/release/tools/cli/gaitslam", "#!/bin/sh\necho whole\n");
  write("build/release/tools/cli/runner/gaitslam", "#!/bin/sh\necho runner\n");
  shell(
      "chmod +x tools/gaitslam build/release/tools/cli/gaitslam build/release/tools/cli/runner/gaitslam; "
      "sleep 0.05; touch build/release/.built-gaitslam build/release/.built-gaitslam_runner");
  const auto commands = [&](const std::string& program) {
    return shell(program + " rnu 2>&1 | sed 's/.*expected one of //; s/;.*//' | tr -d ,").out;
  };
  const std::string of_runner = " " + commands("'" GAITSLAM_RUNNER "'");
  std::istringstream names(commands(GAITSLAM_PROGRAM));
  for (std::string name; names >> name;) {
    if (name == "help") continue;  // both programs have it
    const bool in_runner = std::regex_search(of_runner, std::regex("[ \n]" + name + "[ \n]"));
    for (const std::string& typed : {name, "help " + name})
      EXPECT_EQ(shell("tools/gaitslam " + typed).out, in_runner ? "runner\n" : "whole\n") << typed;
    EXPECT_EQ(shell("tools/gaitslam " + name + " --view").out, "whole\n");
  }
  EXPECT_EQ(shell("tools/gaitslam run x 'walk.controller={program: [tools/gaitslam, walker]}'").out,
            "whole\n");
  write("sim/x", "edited");
  EXPECT_THAT(shell("tools/gaitslam walker").ends(2).err, Has("first run: tools/gaitslam walker --help"));
}

TEST_F(Cli, EachCommandReportsWrongInput) {
  const std::string stand = "walk: {commands: [{stand: {duration_s: 1}}]}\n";
  write("near.yaml", stand + "world: {room: ofice}\n");
  write("far.yaml", "walk: {commands: [{steps: [{forward_m: 0.9, left_m: 0.19}]}]}\n");
  write("control.yaml", R"("a\x9BK\u202Ez": 1)");  // starts a terminal command and reverses the text
  write("result/scenario.yaml", gaitslam("config walk.yaml --yaml").out);
  write("empty/x", "");
  write("old/scenario.yaml", "slam: {plan_orientation: {enabled: true}}\n");
  write("old/about.json", R"({"revision": "0a1b2c"})");
  shell("mkdir pipe && mkfifo pipe/scenario.yaml pipe/score.json");
  write("old/kept", "");
  for (const auto& row : rows_of("tools/rejections.txt"))
    if (row[0] == "any" || GAITSLAM_HAS_WORLD) expect_refused(row.at(1), row.at(2));
  EXPECT_THAT(shell("cat far.yaml | " GAITSLAM_PROGRAM " check /dev/stdin").ends(2).err,
              Has("walk.commands[0]: at"));
}

TEST_F(Cli, AFullDiskIsAnError) {
  EXPECT_EQ(gaitslam("config --keys >/dev/full").ends(74).err, "gaitslam: cannot write to standard output\n");
}

#if GAITSLAM_HAS_WORLD
// A limit of 64 KB for each file stands for the full disk.
TEST_F(Cli, AFullDiskHasItsOwnExitCodeEvenInProcessesThatACommandStarts) {
  for (const std::string command :
       {"run walk.yaml --out a", "run walk.yaml --seeds 1..2 --out b", "record walk.yaml --seeds 1"}) {
    const Ran ran = shell("ulimit -f 128; " GAITSLAM_PROGRAM " " + command).ends(74);
    EXPECT_THAT(ran.complaints(),
                AllOf(StartsWith("gaitslam: "), Has(": cannot be written: File too large")));
  }
}

TEST_F(Cli, CheckRejectsWhateverARunRejectsAtItsStart) {
  const std::string light = "<light directional='true' pos='0 0 3' dir='0 0 -1'/>",
                    floor = "<geom name='floor' type='plane' size='9 9 1'/>";
  const auto room = [&](const std::string& name, const std::string& world) {
    write("rooms/" + name + ".xml",
          "<mujoco><default><default class='floor'/></default><worldbody>" + world + "</worldbody></mujoco>");
    return "world: {room: rooms/" + name + ".xml}\n";
  };
  const std::string stand = scenario_of("{stand: {duration_s: 0.2}}", "rate_hz: 10");
  for (const auto& [keys, complaint] : std::vector<std::pair<std::string, std::string>>{
           {room("hill", light + floor + "<geom name='hill' class='floor' type='box' size='1 1 .01'/>"),
            "walk.commands[0]: stand: at 0.00 s the left sole is planned onto 'hill' at ("},
           {room("endless", light + "<geom name='floor' type='plane' size='0 0 1'/>"),
            "rooms/endless.xml:1: geom size: is 0, expected positive half lengths"},
           {"world: {room: ./none.xml}\n", "bad.yaml:4:9: world.room: "},
           {"estimator: {program: [./none]}\n", "/none cannot be started: No such file or directory"}}) {
    write("bad.yaml", stand + keys);
    for (const std::string command : {"check", "run"})
      EXPECT_THAT(gaitslam(command + " bad.yaml").ends(2).err, Has(complaint)) << command;
  }
}

TEST_F(Cli, ARobotIsCheckedByItsFolderAndItsFirstFileIsNeverOverwritten) {
  const std::string hrp2 = GAITSLAM_SOURCE_DIR "/models/robots/hrp2";
  EXPECT_THAT(ok("robot check '" + hrp2 + "'"),
              Has("mass 56.868 kg, 30 joints with servos", "ok: the left leg reaches 100 %", "ok: stands 5 s",
                  "ok: walks 8 steps in place", "ok: walks 8 s to the left"));
  EXPECT_THAT(ok("robot init '" + hrp2 + "/robot.xml' --no-search --out mine"),
              Has("mine/robot.yaml: written"));
  const std::string first = text_of("mine/robot.yaml");
  EXPECT_THAT(first, Has("base: BODY", "# guess"));
  EXPECT_THAT(gaitslam("robot init '" + hrp2 + "/robot.xml' --no-search --out mine").ends(2).err,
              Has("mine/robot.yaml: already exists"));
  EXPECT_EQ(text_of("mine/robot.yaml"), first);
  write("mine/robot.yaml",
        std::regex_replace(first, std::regex("step_height_m: [0-9.]+"), "step_height_m: 0.005"));
  EXPECT_THAT(gaitslam("robot check mine").ends(1).out,
              Has("FAILED: walks 8 steps in place: the left foot left the floor and landed "));
  write("robot.xml", text_of(hrp2 + "/robot.xml"));
  EXPECT_THAT(ok("robot init --no-search robot.xml"), Has("./robot.yaml: written", "robot check ."));
  write("leg.xml", "<mujoco><worldbody><body name='b'><geom size='1'/></body></worldbody></mujoco>");
  EXPECT_THAT(gaitslam("robot init leg.xml --out leg").ends(2).err,
              Has("leg.xml:1: body: 'b' is the base but has no free joint"));
  EXPECT_THAT(gaitslam("robot check leg.xml").ends(2).err, Has("expected a folder with robot.yaml"));
}

using LongRobotInit = Cli;

TEST_F(LongRobotInit, FindsAGaitThatArrivesAndTheSameOneWithTheSameSeed) {
  const std::string init = "robot init '" GAITSLAM_SOURCE_DIR "/models/robots/g1/robot.xml' --out ";
  ok(init + "first");
  ok(init + "again");
  const std::string file = text_of("first/robot.yaml");
  EXPECT_EQ(text_of("again/robot.yaml"), file);
  EXPECT_THAT(file, Has("# found by walking: arrives at the end of 18 of 18 short walks",
                        "# measured in the same walks\nslam:\n  start: "));
  EXPECT_THAT(ok("robot check first"), Has("ok: walks 8 s back", "ok: walks 8 s turning right"));
}

TEST_F(Cli, APlanThroughFurnitureIsRejectedByEachCommandThatWouldWalkIt) {
  write("ahead.yaml", "walk:\n  commands:\n    - stand: {duration_s: 1}\n    - straight: {forward_m: 9}\n");
  for (const std::string command :
       {"check ahead.yaml", "run ahead.yaml --seeds 1..2", "record ahead.yaml", "run ahead.yaml --cached"}) {
    const Ran ran = shell("GAITSLAM_CACHE=cache " GAITSLAM_PROGRAM " " + command).ends(2);
    EXPECT_THAT(ran.err, AllOf(StartsWith("ahead.yaml:4:7: walk.commands[1]: straight: at "),
                               Has(" is within 0.05 m of chair_2, at (")));
    EXPECT_EQ(ran.out, "") << command;
    EXPECT_FALSE(fs::exists(folder_ / "results")) << command;
  }
}

#else
TEST_F(Cli, RunWithoutASimulatorSaysSo) {
  const std::string circle = kSources + "/scenarios/tangent_circle.yaml";
  expect_refused("run '" + circle + "'", "this build has no simulator (GAITSLAM_WORLD=OFF)");
  EXPECT_THAT(ok("check '" + circle + "'"), Has("not checked whether the robot can walk it"));
}
#endif

// Runs tools/setup.sh with stand-ins for the system's package tools.
TEST_F(Cli, MissingPackagesAreInstalledByRootAndOthersGetTheCommand) {
  write("bin/dpkg-query",
        "#!/bin/sh\necho 'installed=g++ installed=cmake not-installed=ninja-build '\nexit 1\n");
  write("bin/apt-get", "#!/bin/sh\necho \"apt-get $*\"\nexit $APT_RESULT\n");
  write("bin/id", "#!/bin/sh\necho $USER_NUMBER\n");
  write("tools/packages.txt", "# what is needed\ncmake\ng++\nninja-build  # to build\nlibfoo-dev\n");
  const std::string what = "--no-install-recommends ninja-build libfoo-dev";
  for (const auto& [settings, code, said] : std::vector<std::tuple<std::string, int, std::string>>{
           {"USER_NUMBER=0 APT_RESULT=0", 0, "apt-get install -y -qq " + what},
           {"USER_NUMBER=1000 APT_RESULT=0", 2, "sudo apt-get update && sudo apt-get install -y " + what},
           {"USER_NUMBER=0 APT_RESULT=100", 2, "  apt-get update && apt-get install -y " + what}}) {
    const Ran ran =
        shell("chmod +x bin/*; PATH=$PWD/bin:$PATH; export PATH " + settings + "; set -eu; root=$PWD; . '" +
              kSources + "/tools/setup.sh'; install_packages tools/packages.txt; echo done");
    EXPECT_EQ(ran.exit_code, code) << settings;
    EXPECT_EQ(ran.out, code == 0 ? "done\n" : "") << settings;
    EXPECT_THAT(ran.err, Has(said));
  }
}

}  // namespace
}  // namespace tests
