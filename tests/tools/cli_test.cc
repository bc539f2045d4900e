// The command line, without simulations.
#include <gmock/gmock.h>

#include <algorithm>
#include <sstream>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/files/text.h"
#include "tests/tools/command_line.h"

namespace {

using testing::HasSubstr;
using testing::StartsWith;
using tests::Ran;

const std::string kScenarios = std::string(GAITSLAM_SOURCE_DIR) + "/scenarios/";
const std::string kCircle = kScenarios + "tangent_circle.yaml";

class Cli : public tests::CommandLine {
 protected:
  void write_walk(const std::string& name, const std::string& more) const {
    write(name, "walk: {commands: [{stand: {duration_s: 1}}]}\n" + more);
  }
};

TEST_F(Cli, HelpOfTheProgramAndOfEachCommandHasExamples) {
  for (const std::string command : {"", "run ", "replay ", "export ", "score ", "regress ", "compare ",
                                    "baseline update ", "check ", "config "}) {
    const Ran ran = gaitslam(command + "--help");
    EXPECT_EQ(ran.exit_code, 0);
    EXPECT_THAT(ran.out, HasSubstr("Examples:\n  gaitslam " + command));
    EXPECT_EQ(ran.err, "");
  }
}

// 120 libraries and a compiler cost each process 90 ms.
TEST_F(Cli, CodecsAndOpenGLAreNotLoadedBeforeTheyAreNeeded) {
  const Ran ran = shell("LD_TRACE_LOADED_OBJECTS=1 " GAITSLAM_PROGRAM);
  ASSERT_THAT(ran.out, HasSubstr("libopencv_core"));
  for (const char* library : {"libopencv_imgcodecs", "libgdal", "libOSMesa", "libLLVM"})
    EXPECT_EQ(ran.out.find(library), std::string::npos) << library;
}

TEST_F(Cli, VersionNamesRevisionAndLibraries) {
  const Ran ran = gaitslam("--version");
  EXPECT_EQ(ran.exit_code, 0);
  EXPECT_THAT(ran.out, StartsWith("gaitslam "));
  EXPECT_THAT(ran.out, HasSubstr("(revision "));
  EXPECT_THAT(ran.out, HasSubstr("Eigen 3."));
  EXPECT_THAT(ran.out, HasSubstr("OpenCV 4."));
}

// The commands named in tools/gaitslam are those of the runner.
TEST_F(Cli, TheRunnerHasTheCommandsForWhichTheLauncherBuildsIt) {
  const std::string launcher = sim::files::read_text(std::string(GAITSLAM_SOURCE_DIR) + "/tools/gaitslam");
  const size_t begin = launcher.find("  check |");
  const size_t end = launcher.find(')', begin);
  ASSERT_NE(begin, std::string::npos);
  std::istringstream names(launcher.substr(begin, end - begin));
  std::string expected;
  for (std::string name; names >> name;)
    if (name != "|") expected += (expected.empty() ? "" : ", ") + name;
  const Ran ran = shell("'" GAITSLAM_RUNNER
                        "' rnu 2>&1 | sed 's/.*expected one of //; s/;.*//' | tr ',' '\n' | "
                        "tr -d ' ' | sort | paste -sd , | sed 's/,/, /g'");
  EXPECT_EQ(ran.out, expected + "\n");
}

// In a tree with stand-ins for both programs.
TEST_F(Cli, TheLauncherTakesTheWholeProgramForTheView) {
  write("tools/gaitslam", sim::files::read_text(std::string(GAITSLAM_SOURCE_DIR) + "/tools/gaitslam"));
  for (const char* source : {"CMakeLists.txt", "CMakePresets.json", "walking/x", "slam/x", "sim/x"})
    write(source, "");
  write("build/release/tools/cli/gaitslam", "#!/bin/sh\necho whole \"$@\"\n");
  write("build/release/tools/cli/runner/gaitslam", "#!/bin/sh\necho runner \"$@\"\n");
  shell(
      "chmod +x tools/gaitslam build/release/tools/cli/gaitslam build/release/tools/cli/runner/gaitslam; "
      "sleep 0.05; "
      "touch build/release/.built-gaitslam build/release/.built-gaitslam_runner");
  for (const auto& [typed, expected] : std::vector<std::pair<std::string, std::string>>{
           {"run a.yaml", "runner run a.yaml\n"},
           {"run a.yaml --view", "whole run a.yaml --view\n"},
           {"replay r --control --view", "whole replay r --control --view\n"},
           {"reproduce --view", "whole reproduce --view\n"},
           {"view r", "whole view r\n"}})
    EXPECT_EQ(shell("tools/gaitslam " + typed).out, expected);
}

TEST_F(Cli, WrongCommandsAndOptionsAreRejectedWithTheNearest) {
  expect_refused("", "A subcommand is required");
  expect_refused("rnu x.yaml", "unknown command 'rnu', expected one of run, record, ");
  EXPECT_THAT(refusal("rnu x.yaml"), HasSubstr("; did you mean 'run'?"));
  expect_refused("check", "scenarios is required");
  expect_refused("config", "config: expected a scenario's YAML file, or --keys");
  expect_refused("run '" + kCircle + "' --sedes 1..3", "--sedes; did you mean '--seeds'?");
  expect_refused("report x --ouf=y", "; did you mean '--out'?");
  EXPECT_THAT(refusal("config '" + kCircle + "' --frobnicate"),
              testing::AllOf(HasSubstr("--frobnicate"), testing::Not(HasSubstr("did you mean"))));
}

TEST_F(Cli, WrongScenariosOverridesAndResultsAreNamedByEachCommand) {
  write_walk("kitchen.yaml", "world:\n  room: kitchen\n");
  write_walk("near.yaml", "world: {room: ofice}\n");
  write_walk("robot.yaml", "world: {robot: office}\n");
  write_walk("stand.yaml", "world: {room: office}\n");
  write("far.yaml", "walk: {commands: [{steps: [{forward_m: 0.9, left_m: 0.19}]}]}\n");
  write("unknown.yaml", "sede: 1\n");
  write("result/scenario.yaml", gaitslam("config '" + kCircle + "' --yaml").out);
  write("empty/x", "");
  const std::string slurm = "sweep '" + kCircle + "' slam.gyro.sigma_rad_s=0.1,0.2 --backend slurm ";
  for (const auto& [arguments, complaint] : std::vector<std::pair<std::string, std::string>>{
           {"check kitchen.yaml", "kitchen.yaml:3: world.room: is 'kitchen', expected one of "},
           {"check near.yaml", "; did you mean 'office'?"},
           {"check robot.yaml", "robot.yaml:2: world.robot: is 'office', expected one of hrp2"},
           {"check stand.yaml world.room=kitchen", "world.room: is 'kitchen'"},
           {"check world.seed=3", "check: names no scenario, expected a YAML file"},
           {"check far.yaml", "the cause is walk.commands[0].steps[0].forward_m 0.9"},
           {"check unknown.yaml", "unknown.yaml:1:1: sede: unknown key; did you mean 'seed'?"},
           {"config no.yaml", "no.yaml: cannot be read: No such file or directory"},
           {"config '" + kCircle + "' seed=2 slam.gyro.sigma_rad_s=nan",
            "<argument>:2:23: slam.gyro.sigma_rad_s: is 'nan'"},
           {"config '" + kCircle + "' --without camrea", "did you mean 'camera'?"},
           {slurm + "--out \"$(printf 'a\\nb')\"", "has a line break"},
           {"replay no-such-folder", "no-such-folder: no such result folder"},
           {"replay empty", "empty: expected a result folder (with scenario.yaml and recording/)"},
           {"replay result walk.step_length_m=0.1", "walk.step_length_m: shapes the recording"},
           {"run x.yaml --control", "--control requires --view"},
           {"replay result --port 8000", "--port requires --view"},
           {"score empty empty --all-pairs", "need -d or -u"},
           {"leaderboard empty --csv none/t.csv",
            "--csv none/t.csv: the folder none does not exist; create it first, or name another file"},
           {"report result --out none/r.html", "--out none/r.html: the folder none does not exist"},
           {"leaderboard empty --metric rmse", "did you mean 'rmse_m'?"}})
    expect_refused(arguments, complaint);
  EXPECT_THAT(shell("cat stand.yaml | " GAITSLAM_PROGRAM " check world.seed=3 /dev/stdin").out,
              HasSubstr(": valid, a walk of "));
}

TEST_F(Cli, HelpFitsAHundredColumns) {
  for (const std::string command : {"", "run", "replay", "score", "sweep", "tune", "regress", "evaluate"}) {
    const std::string help = gaitslam(command + " --help").out;
    EXPECT_THAT(help, HasSubstr("\nUsage: gaitslam ")) << command;
    std::istringstream lines(help);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << command;
  }
}

// U+009B starts a terminal command, U+202E changes the direction of writing.
TEST_F(Cli, ControlCharactersAreNotPrintedInErrors) {
  write("key.yaml", R"("a\x9BK\u202Ez": 1)");
  write("value.yaml", R"({world: {room: "a\x9BK\u202Ez"}, walk: {commands: [{stand: {duration_s: 1}}]}})");
  const std::string change = "config '" + kCircle + "' 'a\xC2\x9BK\xE2\x80\xAEz=1'";
  for (const std::string& command : {std::string("config key.yaml"), std::string("check key.yaml"),
                                     std::string("check value.yaml"), change}) {
    const std::string said = refusal(command);
    EXPECT_THAT(said, HasSubstr("a?K?z")) << command;
    EXPECT_THAT(said, testing::Not(HasSubstr("\xC2\x9B"))) << command;
    EXPECT_THAT(said, testing::Not(HasSubstr("\xE2\x80\xAE"))) << command;
  }
}

TEST_F(Cli, APipeInAFolderIsRejected) {
  ASSERT_EQ(shell("mkdir -p result/recording && cd result && mkfifo scenario.yaml score.json truth.tum "
                  "estimate.tum recording/manifest.csv")
                .exit_code,
            0);
  for (const std::string command :
       {"export result --format tum", "report result --out r.html", "view result", "score result",
        "replay result", "regress result/score.json", "sweep result/scenario.yaml",
        "tune result/scenario.yaml", "check result/scenario.yaml"})
    EXPECT_THAT(refusal(command), HasSubstr("is not a regular file, expected one")) << command;
}

TEST_F(Cli, CheckNamesEachFileThatIsValidAndEachThatIsNot) {
  write("far.yaml", "walk: {step_length_m: 0.4, commands: [{straight: {forward_m: 2}}]}\n");
  const Ran ran = gaitslam("check '" + kCircle + "' far.yaml no.yaml");
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_THAT(ran.out, HasSubstr("tangent_circle.yaml: valid, a walk of 4"));
  EXPECT_THAT(ran.err, HasSubstr("far.yaml: the walk cannot be planned: "));
  EXPECT_THAT(ran.err, HasSubstr("no.yaml: cannot be read"));
  EXPECT_EQ(gaitslam("check '" + kScenarios + "'*.yaml").exit_code, 0);
}

TEST_F(Cli, ConfigPrintsTheOriginOfEachValue) {
  write("walk.yaml", "seed: 3\nwalk:\n  step_height_m: 0.05\n  commands: [{stand: {duration_s: 1}}]\n");
  const Ran ran = gaitslam("config walk.yaml world.floor_friction=0.5");
  EXPECT_EQ(ran.exit_code, 0);
  EXPECT_THAT(ran.out, testing::ContainsRegex("walk.step_height_m +0.05 +m +0.07 +walk.yaml:3\n"));
  EXPECT_THAT(ran.out, testing::ContainsRegex("world.floor_friction +0.5 +0.15 +argument 1\n"));
  EXPECT_THAT(ran.out, testing::ContainsRegex("walk.step_length_m +0.15 +m +0.15 +default\n"));
  EXPECT_THAT(ran.out, testing::Not(HasSubstr("slam.")));
}

TEST_F(Cli, ConfigListsAllKeysWithRangeAndMeaning) {
  const Ran ran = gaitslam("config --keys");
  EXPECT_EQ(ran.exit_code, 0);
  EXPECT_THAT(ran.out, HasSubstr("slam.gyro.sigma_rad_s\n    assumed standard deviation"));
  EXPECT_THAT(ran.out, testing::ContainsRegex("tangent_arc +radius_m"));
  EXPECT_THAT(ran.out, HasSubstr("ate_se3_rmse_m"));
}

TEST_F(Cli, AFullDiskIsAnError) {
  const Ran ran = gaitslam("config --keys >/dev/full");
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_EQ(ran.err, "gaitslam: cannot write to standard output\n");
}

#if GAITSLAM_HAS_WORLD
// A temporary folder of one page that is full; only root can mount it.
TEST_F(Cli, AFullTemporaryFolderIsNamed) {
  const Ran ran = shell(
      "mkdir full && unshare -m sh -c 'mount -t tmpfs -o size=4k none full || exit 77; "
      "head -c 4096 /dev/zero >full/page; TMPDIR=$PWD/full exec \"$0\" run \"$1\" --seeds 1,2 --out out' '" +
      std::string(GAITSLAM_PROGRAM) + "' '" + kCircle + "' || exit $?");
  if (ran.exit_code == 77 || ran.err.starts_with("unshare")) GTEST_SKIP() << "nothing can be mounted here";
  if (ran.err.starts_with("ThreadSanitizer"))
    GTEST_SKIP() << "the sanitizer itself needs the temporary folder";
  EXPECT_EQ(ran.exit_code, 2) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("cannot be written: No space left on device"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

TEST_F(Cli, APlanThroughTheRoomIsRejectedByEachCommandThatWouldWalkIt) {
  write("ahead.yaml", "walk:\n  commands:\n    - stand: {duration_s: 1}\n    - straight: {forward_m: 9}\n");
  for (const std::string command :
       {"check ahead.yaml", "run ahead.yaml", "run ahead.yaml --seeds 1..2", "record ahead.yaml",
        "record ahead.yaml --seeds 1..2", "run ahead.yaml --cached"}) {
    const Ran ran = shell("GAITSLAM_CACHE=cache " GAITSLAM_PROGRAM " " + command);
    EXPECT_EQ(ran.exit_code, 2) << command;
    EXPECT_THAT(ran.err, StartsWith("ahead.yaml:4:7: walk.commands[1]: straight: at ")) << command;
    EXPECT_THAT(ran.err, HasSubstr(" is within 0.05 m of chair_2, at (")) << command;
    EXPECT_EQ(ran.out, "") << command;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "results")) << command;
  }
  const Ran allowed = gaitslam("run ahead.yaml limits.ending=[completed,collided]");
  EXPECT_EQ(allowed.exit_code, 0) << allowed.err;
  EXPECT_THAT(text_of("results/ahead/seed-1/about.json"), HasSubstr(" touched chair_2 at ("));
}

TEST_F(Cli, RunRejectsBadOptionsBeforeItSimulates) {
  const std::string run = "run '" + kCircle + "' ";
  expect_refused("run", "scenario is required");
  expect_refused("run no.yaml", "no.yaml: cannot be read");
  expect_refused(run + "--seeds 5..1",
                 "--seeds 5..1: '5..1' goes backwards, expected for example 1..5 or 1,2,7");
  expect_refused(run + "--seeds 1,x", "'x' is not a seed");
  expect_refused(run + "--seeds 1..3,2", "a seed is given twice");
  expect_refused(run + "--seeds ''", "'' is not a seed");
  expect_refused(run + "--seeds 1..2 seed=3", "--seeds and seed= are both given, expected one of them");
  expect_refused(run + "--seeds 1..2 --jobs 0", "--jobs");
  expect_refused(run + "--out /dev/null/x", "/dev/null/x: cannot be written: /dev/null: Not a directory");
  expect_refused(run + "--out ''", "--out: is empty");
  expect_refused(run + "--out '" + kCircle + "'", "is a file, expected a folder for results");
  expect_refused(run + "world.room=no_such_room", "no_such_room");
  write("old/kept", "");
  expect_refused(run + "--out old", "old: exists already; --force replaces what the command writes there");
}
#else
TEST_F(Cli, RunWithoutASimulatorSaysSo) {
  expect_refused("run '" + kCircle + "'", "this build has no simulator (GAITSLAM_WORLD=OFF)");
  EXPECT_THAT(gaitslam("check '" + kCircle + "'").out,
              HasSubstr("whether it is clear of its room was not checked"));
}
#endif

/// tools/setup.sh with stand-ins for the system's package tools.
class Setup : public tests::CommandLine {
 protected:
  Setup() {
    write("bin/dpkg-query",
          "#!/bin/sh\necho 'installed=g++ installed=cmake not-installed=ninja-build '\nexit 1\n");
    write("bin/apt-get", "#!/bin/sh\necho \"apt-get $*\"\nexit $APT_RESULT\n");
    write("bin/id", "#!/bin/sh\necho $USER_NUMBER\n");
    write("tools/packages.txt", "# what is needed\ncmake\ng++\nninja-build  # to build\nlibfoo-dev\n");
  }
  Ran install(const std::string& settings) const {
    return shell("chmod +x bin/*; PATH=$PWD/bin:$PATH; export PATH " + settings +
                 "; set -eu; root=$PWD; . " GAITSLAM_SOURCE_DIR
                 "/tools/setup.sh; install_packages tools/packages.txt; echo done");
  }
};

TEST_F(Setup, MissingPackagesAreInstalledByRootAndOthersGetTheCommand) {
  const std::string what = "--no-install-recommends ninja-build libfoo-dev";
  for (const auto& [settings, code, said] : std::vector<std::tuple<std::string, int, std::string>>{
           {"USER_NUMBER=0 APT_RESULT=0", 0, "apt-get install -y -qq " + what},
           {"USER_NUMBER=1000 APT_RESULT=0", 2, "sudo apt-get update && sudo apt-get install -y " + what},
           {"USER_NUMBER=0 APT_RESULT=100", 2, "  apt-get update && apt-get install -y " + what}}) {
    const Ran ran = install(settings);
    EXPECT_EQ(ran.exit_code, code) << settings;
    EXPECT_EQ(ran.out, code == 0 ? "done\n" : "") << settings;
    EXPECT_THAT(ran.err, HasSubstr(said));
  }
}

}  // namespace
