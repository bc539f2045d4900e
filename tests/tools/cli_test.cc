// The command line and the regression gate, on made-up results: nothing here simulates.
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

class Regress : public CommandLine {
 protected:
  Regress() {
    write("walk.yaml", scenario_of("{stand: {duration_s: 1}}") + "limits: {rmse_m: {at_most: 1}}\n");
    write("suites/ci.yaml",
          "seeds: 1..3\nscenarios:\n  - scenario: ../walk.yaml\n"
          "    gate: {rmse_m: {percent: 10}, rpe_1m_m: {percent: 10}}\n");
  }

  /// Writes the results of seeds, with errors of `factor` times 0.10, 0.11, ...
  void write_results(const std::string& set, double factor, int seeds = 3, const std::string& changes = "",
                     int first = 1) const {
    for (int i = 0; i < seeds; ++i) {
      const std::string folder = fmt::format("{}/walk/seed-{}", set, first + i);
      write(folder + "/scenario.yaml",
            gaitslam(fmt::format("config walk.yaml seed={} {} --yaml", first + i, changes)).out);
      write(folder + "/about.json", R"({"recording_xxh3_128": "r"})");
      write(folder + "/score.json",
            fmt::format(
                R"({{"scenario": "walk", "limits": [], "seed": {}, "ending": "completed", "metrics": {{)"
                R"("rmse_m": {{"value": {}, "unit": "m"}}, "rpe_1m_m": {{"value": 0.1, "unit": "m"}}}}}})",
                first + i, factor * (0.1 + 0.01 * i)));
      write(folder + "/timing.json", "{}");
    }
  }
  void make_baseline() const {
    write_results("old", 1);
    EXPECT_THAT(ok("baseline update suites/ci.yaml --results old --reason 'the first'"),
                Has("NEW", "written to baselines/ci.json"));
  }
};

TEST_F(Regress, AnUnchangedRerunIsIdenticalAndAWorseOneFailsWithACommandToRepeatIt) {
  make_baseline();
  EXPECT_THAT(ok("regress suites/ci.yaml --results old"),
              AllOf(Has("0 of 4 rows failed", "the same recordings"),
                    ContainsRegex("rmse_m +0.11 +0 % +- +- +-  IDENTICAL")));
  write_results("new", 1.5);
  const std::string regress = "regress suites/ci.yaml --results new ";
  const Ran ran = shell("GITHUB_STEP_SUMMARY=s.md " GAITSLAM_PROGRAM " " + regress +
                        "--junit j.xml --markdown m.md --json j.json --github")
                      .ends(1);
  EXPECT_THAT(ran.out, AllOf(Has("    " GAITSLAM_PROGRAM " run walk.yaml seed=3\n",
                                 "::error file=walk.yaml,title=walk rmse_m%3A FAIL::"),
                             ContainsRegex("rmse_m +0.11 +\\+50 % +- +- +-  FAIL")));
  EXPECT_THAT(text_of("j.xml"), Has("failures=\"1\""));
  EXPECT_THAT(text_of("m.md"), Has("| `rmse_m` | **FAIL** | 0.11 m changes by +50 %"));
  EXPECT_EQ(text_of("s.md"), text_of("m.md"));
  EXPECT_THAT(text_of("j.json"), Has("\"exit_code\": 1"));
  const Ran quiet = gaitslam(regress + "--quiet").ends(1);
  EXPECT_EQ(quiet.out + quiet.err, "");
  for (const std::string& command : {regress, std::string("compare old new ")}) {
    write("v.json", gaitslam(command + "--json").out);
    checked("verdicts", "v.json").ends(0);
  }
  // script(1) gives the program a terminal.
  const auto painted = [&](const std::string& environment) {
    return shell("env -u NO_COLOR TERM=xterm " + environment + " script -qec '" GAITSLAM_PROGRAM " " +
                 regress + "' typescript </dev/null")
        .out;
  };
  for (const char* wanted : {"", "NO_COLOR="}) EXPECT_THAT(painted(wanted), Has("\033[31mFAIL\033[0m"));
  for (const char* unwanted : {"NO_COLOR=1", "TERM=dumb"}) EXPECT_THAT(painted(unwanted), Lacks("\033[3"));
}

TEST_F(Regress, ResultsThatCannotBeComparedAreRefusedInOneLine) {
  expect_refused("regress suites/ci.yaml --results old", "baselines/ci.json: does not exist");
  make_baseline();
  write("suites/empty.yaml", "seeds: 1\nscenarios: []\n");
  write("empty/x", "");
  write_results("damaged", 1);
  write("damaged/walk/seed-1/score.json", "{");
  write_results("others", 1, 3, "", 100);
  expect_refused({{"regress none.yaml", "none.yaml: cannot be read"},
                  {"regress suites/ci.yaml --results none", "the result of seed 1 is missing"},
                  {"regress suites/ci.yaml --results old --seeds 1..4",
                   "has no seed 4 of walk; '" GAITSLAM_PROGRAM
                   " regress suites/ci.yaml --against ../base/tools/gaitslam --seeds 1..32' compares with "
                   "another build"},
                  {"regress suites/ci.yaml --results old --baseline 'no file.json'",
                   "no file.json: does not exist; '" GAITSLAM_PROGRAM " regress suites/ci.yaml --against "},
                  {"regress suites/ci.yaml --against none",
                   "--against none: does not exist, expected the gaitslam program"},
                  {"regress suites/ci.yaml --against walk.yaml", "--against walk.yaml: cannot be executed"},
                  {"regress suites/ci.yaml --against /bin/false", "--against /bin/false: --version fails"},
                  {"regress suites/ci.yaml --results old seed=3", "seed=3: the suite sets names and seeds"},
                  {"regress suites/ci.yaml --results old slam.vision.sigma_px=3",
                   "was made with a different configuration"},
                  {"regress suites/empty.yaml", "the suite is empty"},
                  {"baseline update suites/ci.yaml --results old --reason ' '", "--reason: is empty"},
                  {"compare old none", "none: not a folder of results"},
                  {"compare old empty", "empty: contains no result, expected seed-<n>/score.json"},
                  {"compare old others", "have no seed in common"},
                  {"compare old damaged", "seed-1/score.json"}});
}

TEST_F(Regress, AGateForWhichNoRunHasAValueIsAnErrorOfTheSuite) {
  write_results("old", 1);
  write("suites/ci.yaml",
        "seeds: 1..3\nscenarios:\n  - scenario: ../walk.yaml\n    gate: {rmse_m: {}, loop_landmarks: "
        "{absolute: 2}}\n");
  for (const char* command : {"baseline update suites/ci.yaml --results old --reason first",
                              "baseline update suites/ci.yaml --results old --reason first --dry-run"})
    expect_refused(command, "suites/ci.yaml:4:24: gate.loop_landmarks: no run of walk has a value");
}

TEST_F(Regress, AnUndecidedRowNamesTheCommandThatDecidesIt) {
  write_results("old", 1, 8);
  write("suites/ci.yaml",
        "seeds: 1..8\nscenarios: [{scenario: ../walk.yaml, gate: {rmse_m: {percent: 1}}}]\n");
  ok("baseline update suites/ci.yaml --results old --reason first");
  for (int seed = 1; seed <= 8; ++seed) write_results("new", seed % 3 == 0 ? 0.8 : 1.2, 1, "", seed);
  const Ran ran = gaitslam("regress suites/ci.yaml --results new --junit j.xml").ends(1);
  EXPECT_THAT(ran.out,
              Has("UNDECIDED", "  to decide:\n    " GAITSLAM_PROGRAM " regress suites/ci.yaml --against "
                               "../base/tools/gaitslam --seeds 1..32\n"));
  EXPECT_THAT(ran.out, Lacks("baseline update"));
  EXPECT_THAT(text_of("j.xml"), Has("to decide: "));
}

TEST_F(Regress, TwoFoldersOfOneScenarioInATreeAreRefusedByName) {
  write_results("one", 1);
  shell("mkdir two && cp -r one/walk two/a && cp -r one/walk two/b");
  for (const char* const command : {"compare one two", "compare two one --across"})
    expect_refused(command, "two/a and two/b contain the same scenario, walk; compare one of them");
  ok("compare two/a two/b");
}

TEST_F(Regress, AChangedScenarioCountsAsAnotherConfigurationUntilTheBaselineIsUpdated) {
  make_baseline();
  write("walk.yaml",
        "walk: {step_height_m: 0.05, commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\n"
        "limits: {rmse_m: {at_most: 1}}\n");
  expect_refused("regress suites/ci.yaml --results old",
                 "the configuration of walk differs from the baseline baselines/ci.json: walk.step_height_m: "
                 "0.07 -> 0.05; '" GAITSLAM_PROGRAM " regress ");
  const std::string update = "baseline update suites/ci.yaml --reason 'lower steps' --results ",
                    before = text_of("baselines/ci.json");
  write_results("bad", 20);
  EXPECT_THAT(gaitslam(update + "bad").ends(1).err, Has("because a result misses a limit"));
  write_results("new", 2);
  EXPECT_THAT(ok(update + "new --dry-run"),
              AllOf(Has("FAIL", "walk.step_height_m: 0.07 -> 0.05"), Lacks("written")));
  EXPECT_EQ(text_of("baselines/ci.json"), before);
  ok(update + "new");
  EXPECT_THAT(text_of("baselines/ci.json"), Has("the first", "lower steps"));
  EXPECT_THAT(ok("regress suites/ci.yaml --results new"), Has("IDENTICAL"));
}

TEST_F(Regress, ComparePairsResultsBySeed) {
  write_results("a", 1, 8);
  write_results("b", 1.3, 8);
  EXPECT_THAT(gaitslam("compare a b").ends(1).out,
              AllOf(ContainsRegex("rmse_m .*\\+30 % +\\[\\+24,\\+36\\] +96.1 % +0.047  FAIL"),
                    Has(GAITSLAM_PROGRAM " run b/walk/seed-8/scenario.yaml")));
  ok("compare b/walk a/walk");
  EXPECT_THAT(ok("compare a/walk/seed-1 a/walk/seed-1"), Has("1 seed paired"));
}

TEST_F(Regress, CompareRefusesDifferentScenariosUnlessAskedTo) {
  write_results("a", 1);
  write_results("longer", 2, 3, "'walk.commands=[{stand: {duration_s: 2}}]'");
  write_results("dark", 2, 3, "--without camera,slam");
  write_results("named", 2, 3, "name=other");
  write_results("tuned", 2, 3, "slam.vision.sigma_px=3");
  expect_refused(
      {{"compare a longer", "a/walk and longer/walk: walk.commands differs"},
       {"compare a dark", "camera."},
       {"compare dark a", "camera."},
       {"compare a/walk/seed-1 longer/walk/seed-1", "--across compares different scenarios"},
       {"compare a named", "a/walk contains the scenario walk, but named/walk contains other; --across"}});
  EXPECT_EQ(gaitslam("compare a tuned").exit_code, 1) << "a change of the filter is compared";
  for (const char* other : {"longer", "named"}) {
    EXPECT_THAT(gaitslam(std::string("compare --across a ") + other).ends(1).out,
                ContainsRegex("rmse_m .* FAIL"));
  }
  shell("mkdir both && mv a/walk both && mv named/walk both/other");
  expect_refused("compare both longer", "walk.commands differs");
  EXPECT_THAT(ok("compare both both"), Has("IDENTICAL"));
}

#if GAITSLAM_HAS_WORLD
TEST_F(Regress, ThreeSeedsDecideIfTheyAreIdenticalElseAllSeedsOfTheSuiteRun) {
  write("walk.yaml", kShortWalk);
  write("suites/ci.yaml",
        "seeds: 1..4\nscenarios: [{scenario: ../walk.yaml, gate: {rmse_m: {percent: 10}}}]\n");
  ok("baseline update suites/ci.yaml --reason first --jobs 2 --out base");
  EXPECT_THAT(ok("regress suites/ci.yaml --jobs 2 --out out"),
              AllOf(Has("3 of 4 seeds, which decide"), ContainsRegex("rmse_m .*IDENTICAL")));
  EXPECT_FALSE(fs::exists(folder_ / "out/walk/seed-4"));
  shell("sed -i 's/^.rmse_m.: .[0-9.e-]*/\"rmse_m\": [1e-9/' baselines/ci.json");
  EXPECT_THAT(gaitslam("regress suites/ci.yaml --jobs 2 --out out").out,
              AllOf(Lacks("which decide"), ContainsRegex("rmse_m ")));
  EXPECT_TRUE(fs::exists(folder_ / "out/walk/seed-4"));
}

// The other build is a script around this one, which can give its estimates other noise and can fail.
TEST_F(Regress, AnotherBuildRunsTheSameWalksOnSharedRecordings) {
  write("walk.yaml", kShortWalk);
  write("suites/ci.yaml",
        "seeds: 1,2\nscenarios: [{scenario: ../walk.yaml, gate: {rmse_m: {percent: 10}}}]\n");
  write("other",
        "#!/bin/sh\n[ \"$1\" = --version ] || echo \"$*\" >>calls\n"
        "[ \"$1\" != run ] || set -- \"$@\" $CHANGES\nexec " GAITSLAM_PROGRAM " \"$@\"\n");
  shell("chmod +x other");
  const std::string regress = "regress suites/ci.yaml --against ./other --out out --jobs ";
  const Ran ran = gaitslam(regress + "2");
  EXPECT_LE(ran.exit_code, 1) << "1: on a busy machine, the times are undecided";
  const std::string& first = ran.out;
  EXPECT_THAT(first, AllOf(Has("against ./other (gaitslam "), ContainsRegex("rmse_m .* IDENTICAL"),
                           ContainsRegex("frame_cpu_ms_mean +[0-9.]+ ")));
  EXPECT_EQ(shell("ls 'the cache' | grep -c -v lock").out, "2\n") << "the recordings are shared";
  EXPECT_EQ(shell("wc -l <calls").out, "2\n");
  EXPECT_EQ(gaitslam(regress + "1").out, "4 results finished before\n" + first);
  EXPECT_EQ(shell("wc -l <calls").out, "2\n") << "finished results are kept";
  shell("echo >>other");  // another build
  EXPECT_THAT(shell("CHANGES='errors.gyro.sigma_rad_s=1' " GAITSLAM_PROGRAM " " + regress + "1").out,
              ContainsRegex("rmse_m .* (BETTER|FAIL|UNDECIDED)"));
  shell("echo >>other");
  const Ran unknown = shell("CHANGES=slam.new_key=1 " GAITSLAM_PROGRAM " " + regress + "1").ends(2);
  EXPECT_THAT(unknown.err, Has("/other: seed 1: ", "slam.new_key: unknown key"));
  write("other", "#!/bin/sh\n[ \"$1\" = --version ] && exec " GAITSLAM_PROGRAM " --version\nexit 3\n");
  EXPECT_THAT(gaitslam(regress + "1").ends(2).err, Has("--against ./other: left no result"));
}

TEST_F(Regress, TheAuditNamesGatesThatNoDisturbanceMoves) {
  write("walk.yaml", kShortWalk);
  write("suites/ci.yaml",
        "seeds: 1\nscenarios: [{scenario: ../walk.yaml, gate: {rmse_m: {percent: 10}, path_length_m: "
        "{percent: 10}}}]\n");
  const Ran ran = gaitslam("regress suites/ci.yaml --audit --jobs 2 --out out").ends(1);
  EXPECT_THAT(ran.out, AllOf(ContainsRegex("rmse_m .*(FAIL|UNDECIDED|MISSING|BETTER)"),
                             Has("walk: path_length_m: no disturbance moves this gate\n"),
                             Lacks("walk: rmse_m: no disturbance")));
}
#endif

}  // namespace
}  // namespace tests
