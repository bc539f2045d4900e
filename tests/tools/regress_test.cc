// The regression gate through the program, on made-up results: nothing here simulates.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/tools/command_line.h"

namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;
using tests::Ran;

class Regress : public tests::CommandLine {
 protected:
  Regress() {
    write("walk.yaml",
          "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\n"
          "limits: {rmse_m: {at_most: 1}}\n");
    write("suites/ci.yaml",
          "seeds: 1..3\nscenarios:\n  - scenario: ../walk.yaml\n"
          "    gate: {rmse_m: {percent: 10}, rpe_1m_m: {percent: 10}}\n");
  }

  /// Writes the result of one seed.
  void write_result(const std::string& set, int seed, double rmse, const std::string& recording = "r",
                    const std::string& ending = "completed", const std::string& changes = "") const {
    const std::string folder = fmt::format("{}/walk/seed-{}", set, seed);
    write(folder + "/scenario.yaml",
          gaitslam(fmt::format("config walk.yaml seed={} {} --yaml", seed, changes)).out);
    write(folder + "/about.json", fmt::format(R"({{"recording_xxh3_128": "{}"}})", recording));
    write(folder + "/timing.json", "{}");
    write(
        folder + "/score.json",
        fmt::format(
            R"({{"scenario": "walk", "limits": [], "seed": {}, "ending": "{}", "metrics": {{"rmse_m": {{"value": {}, "unit": "m"}},)"
            R"("rpe_1m_m": {{"value": 0.1, "unit": "m"}}}}}})",
            seed, ending, rmse));
  }
  void write_results(const std::string& set, double factor, int seeds = 3, int first = 1) const {
    for (int i = 0; i < seeds; ++i) write_result(set, first + i, factor * (0.1 + 0.01 * i));
  }
  void make_baseline() const {
    write_results("old", 1);
    const Ran ran = gaitslam("baseline update suites/ci.yaml --results old --reason 'the first'");
    ASSERT_EQ(ran.exit_code, 0) << ran.err;
    EXPECT_THAT(ran.out, AllOf(HasSubstr("NEW"), HasSubstr("written to baselines/ci.json")));
  }
};

TEST_F(Regress, AnUnchangedRerunIsIdentical) {
  make_baseline();
  const Ran ran = gaitslam("regress suites/ci.yaml --results old");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_THAT(ran.out, ContainsRegex("rmse_m +0.11 +0.11 +0 % +- +-  IDENTICAL"));
  EXPECT_THAT(ran.out, HasSubstr("0 of 4 rows failed"));
  EXPECT_THAT(ran.out, HasSubstr("the same recordings"));
}

TEST_F(Regress, AWorseOneFailsWithACommandToRunItAgain) {
  make_baseline();
  write_results("new", 1.5);
  const Ran ran =
      gaitslam("regress suites/ci.yaml --results new --junit j.xml --markdown m.md --json j.json --github");
  EXPECT_EQ(ran.exit_code, 1) << ran.err;
  EXPECT_THAT(ran.out, ContainsRegex("rmse_m +0.11 +0.165 +\\+50 % +- +-  FAIL"));
  const std::string command = "    tools/gaitslam run walk.yaml seed=3\n";
  EXPECT_THAT(ran.out, HasSubstr(command));
  EXPECT_EQ(ran.out.find(command), ran.out.rfind(command)) << "it stands once for all rows of the run";
  EXPECT_THAT(ran.out, HasSubstr("::error file=walk.yaml,title=walk rmse_m%3A FAIL::"));
  EXPECT_THAT(text_of("j.xml"), HasSubstr("failures=\"1\""));
  EXPECT_THAT(text_of("m.md"), HasSubstr("| `rmse_m` | **FAIL** |"));
  EXPECT_THAT(text_of("j.json"), HasSubstr("\"exit_code\": 1"));
  const Ran quiet = gaitslam("regress suites/ci.yaml --results new --quiet");
  EXPECT_EQ(quiet.exit_code, 1);
  EXPECT_EQ(quiet.out + quiet.err, "");
  for (const char* json : {"regress suites/ci.yaml --results new --json", "compare old new --json"}) {
    const Ran checked = shell(GAITSLAM_PROGRAM " " + std::string(json) +
                              " >v.json; /usr/bin/python3 '" GAITSLAM_SOURCE_DIR
                              "/tests/tools/check_schema.py' '" GAITSLAM_SOURCE_DIR
                              "/sim/result/schemas/verdicts.schema.json' v.json");
    EXPECT_EQ(checked.exit_code, 0) << checked.err;
  }
}

TEST_F(Regress, TwoFoldersOfOneScenarioInATreeAreRefusedByName) {
  write_results("one", 1);
  for (const char* const folder : {"two/a", "two/b"}) {
    std::filesystem::create_directories(folder_ / folder);
    std::filesystem::copy(folder_ / "one/walk", folder_ / folder, std::filesystem::copy_options::recursive);
  }
  for (const char* const command : {"compare one two", "compare two one --across", "compare two two"}) {
    const Ran ran = gaitslam(command);
    EXPECT_EQ(ran.exit_code, 2) << ran.out;
    EXPECT_THAT(ran.err, HasSubstr("two/a and two/b contain the same scenario, walk; compare one of them"));
  }
  EXPECT_EQ(gaitslam("compare two/a two/b").exit_code, 0);
  const Ran table = gaitslam("leaderboard two two/a --metric rmse_m");
  EXPECT_EQ(table.out, gaitslam("leaderboard two --metric rmse_m").out);
  EXPECT_THAT(table.out, ContainsRegex("filter +[0-9]+ % +3/3")) << table.err;
}

// script(1) gives the program a terminal.
TEST_F(Regress, ColoursAreForTerminalsThatWantThem) {
  make_baseline();
  write_results("new", 1.5);
  const auto painted = [&](const std::string& environment) {
    return shell("env -u NO_COLOR TERM=xterm " + environment +
                 " script -qec '" GAITSLAM_PROGRAM
                 " regress suites/ci.yaml --results new' typescript </dev/null")
        .out;
  };
  EXPECT_THAT(painted(""), HasSubstr("\033[31mFAIL\033[0m"));
  EXPECT_THAT(painted("NO_COLOR="), HasSubstr("\033[31mFAIL\033[0m")) << "it is empty";
  EXPECT_THAT(painted("NO_COLOR=1"), Not(HasSubstr("\033[3")));
  EXPECT_THAT(painted("TERM=dumb"), Not(HasSubstr("\033[3")));
  EXPECT_THAT(
      shell("env -u NO_COLOR TERM=xterm " GAITSLAM_PROGRAM " regress suites/ci.yaml --results new").out,
      Not(HasSubstr("\033")));
}

TEST_F(Regress, ALimitAndAFallFailWhateverTheBaseline) {
  make_baseline();
  write_results("new", 1);
  write_result("new", 2, 1.5);
  EXPECT_EQ(gaitslam("regress suites/ci.yaml --results new").exit_code, 1);
  write_result("new", 2, 0.11, "r", "fell");
  const Ran ran = gaitslam("regress suites/ci.yaml --results new");
  EXPECT_EQ(ran.exit_code, 3);
  EXPECT_THAT(ran.out, ContainsRegex("limit ending completed +2/3  RUN FAILED\n.*worst seed 2\n"));
}

TEST_F(Regress, WhatCannotBeComparedIsRefusedInOneLine) {
  expect_refused("regress suites/ci.yaml --results old", "baselines/ci.json: does not exist");
  make_baseline();
  expect_refused("regress none.yaml", "none.yaml: cannot be read");
  expect_refused("regress suites/ci.yaml --results none", "there is no result of seed 1");
  expect_refused("regress suites/ci.yaml --results old --seeds 1..4", "has no seed 4 of walk");
  expect_refused("regress suites/ci.yaml --results old seed=3",
                 "seed=3: a suite has its own names and seeds");
  expect_refused("regress suites/ci.yaml --results old slam.vision.sigma_px=3",
                 "was made with another configuration");
  expect_refused("baseline update suites/ci.yaml --results old --reason ' '", "--reason: is empty");
  write("suites/empty.yaml", "seeds: 1\nscenarios: []\n");
  expect_refused("regress suites/empty.yaml", "the suite is empty");
  std::string changed = text_of("baselines/ci.json");
  changed[changed.find("0.1,")] = '9';
  write("baselines/ci.json", changed);
  expect_refused("regress suites/ci.yaml --results old", "was edited after it was written");
}

TEST_F(Regress, AChangedScenarioIsAnotherConfigurationUntilTheBaselineIsUpdated) {
  make_baseline();
  write("walk.yaml",
        "walk: {step_height_m: 0.05, commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\n");
  expect_refused(
      "regress suites/ci.yaml --results old",
      "walk has another configuration than the baseline baselines/ci.json: walk.step_height_m: not set -> "
      "0.05; run 'gaitslam baseline update' to store it");
  write_results("new", 2);
  const std::string update = "baseline update suites/ci.yaml --results new --reason 'lower steps'";
  const Ran dry = gaitslam(update + " --dry-run");
  EXPECT_EQ(dry.exit_code, 0) << dry.err;
  EXPECT_THAT(dry.out, AllOf(HasSubstr("FAIL"), HasSubstr("walk.step_height_m: not set -> 0.05"),
                             Not(HasSubstr("written"))));
  EXPECT_EQ(gaitslam(update).exit_code, 0);
  EXPECT_THAT(text_of("baselines/ci.json"), AllOf(HasSubstr("the first"), HasSubstr("lower steps")));
  EXPECT_THAT(gaitslam("regress suites/ci.yaml --results new").out, HasSubstr("IDENTICAL"));
}

TEST_F(Regress, ABaselineKeepsAllLimits) {
  make_baseline();
  const std::string before = text_of("baselines/ci.json");
  write_results("new", 20);
  const Ran ran = gaitslam("baseline update suites/ci.yaml --results new --reason 'worse'");
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_THAT(ran.err, HasSubstr("because a result misses a limit"));
  EXPECT_EQ(text_of("baselines/ci.json"), before);
}

TEST_F(Regress, ComparePairsBySeed) {
  write_results("a", 1, 8);
  write_results("b", 1.3, 8);
  const Ran ran = gaitslam("compare a b");
  EXPECT_EQ(ran.exit_code, 1) << ran.err;
  EXPECT_THAT(ran.out, ContainsRegex("rmse_m .*\\+30 % +\\[\\+22,\\+38\\] +0.047  FAIL"));
  EXPECT_THAT(ran.out, HasSubstr("tools/gaitslam run b/walk/seed-8/scenario.yaml"));
  EXPECT_EQ(gaitslam("compare b/walk a/walk").exit_code, 0);
  EXPECT_THAT(gaitslam("compare a b --gate rmse_m=50%").out, ContainsRegex("rmse_m .* SAME"));
  EXPECT_THAT(gaitslam("compare a/walk/seed-1 a/walk/seed-1").out, HasSubstr("1 seed paired"));
  write_results("c", 2, 8, 100);
  EXPECT_THAT(gaitslam("compare a c").out,
              AllOf(HasSubstr("no seeds in common"), ContainsRegex("rmse_m .* FAIL")));
}

TEST_F(Regress, CompareRefusesDifferentScenariosUnlessAskedTo) {
  write_results("a", 1);
  for (int seed = 1; seed <= 3; ++seed) {
    write_result("longer", seed, 0.2, "r", "completed", "'walk.commands=[{stand: {duration_s: 2}}]'");
    write_result("dark", seed, 0.2, "r", "completed", "--without camera,slam");
    write_result("named", seed, 0.2, "r", "completed", "name=other");
    write_result("tuned", seed, 0.2, "r", "completed", "slam.vision.sigma_px=3");
  }
  expect_refused("compare a longer", "a/walk and longer/walk: walk.commands differs");
  expect_refused("compare a dark", "camera.");
  expect_refused("compare dark a", "camera.");
  expect_refused("compare a/walk/seed-1 longer/walk/seed-2", "--across compares different scenarios");
  expect_refused("compare a named", "a/walk is of the scenario walk, named/walk of other; --across");
  EXPECT_EQ(gaitslam("compare a tuned").exit_code, 1) << "a change of the filter is what is compared";
  for (const char* other : {"longer", "named"}) {
    const Ran ran = gaitslam(std::string("compare --across a ") + other);
    EXPECT_EQ(ran.exit_code, 1) << ran.err;
    EXPECT_THAT(ran.out, ContainsRegex("rmse_m .* FAIL"));
  }
  std::filesystem::create_directories(folder_ / "both");
  std::filesystem::rename(folder_ / "a/walk", folder_ / "both/walk");
  std::filesystem::rename(folder_ / "named/walk", folder_ / "both/other");
  expect_refused("compare both longer", "walk.commands differs");
  EXPECT_THAT(gaitslam("compare both both").out, HasSubstr("IDENTICAL"));
}

TEST_F(Regress, CompareRefusesWhatAreNoResults) {
  write_results("a", 1);
  expect_refused("compare a none", "none: not a folder of results");
  write("empty/x", "");
  expect_refused("compare a empty", "empty: contains no result, expected seed-<n>/score.json");
  expect_refused("compare a a --gate rmse=1%",
                 "--gate rmse=1%: unknown metric 'rmse'; did you mean 'rmse_m'?");
  expect_refused("compare a a --gate rmse_m", "--gate rmse_m: expected a tolerance");
  write("a/walk/seed-1/score.json", "{");
  expect_refused("compare a a", "seed-1/score.json");
}

}  // namespace
