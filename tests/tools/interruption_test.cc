// Interrupted and repeated commands: old results stay until new ones are complete, and a rerun resumes.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/sim/result/result_folder.h"
#include "tests/tools/command_line.h"

namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using tests::differences;
using tests::kBlind;
using tests::kBlindStand;
using tests::Ran;

class Interruption : public tests::CommandLineWithCache {
 protected:
  Interruption() {
    write("walk.yaml", tests::kShortWalk);
    write("stand.yaml", std::string(tests::kStand) + "name: walk\n");
  }

  /// Runs a command in the background until a shell condition is true, and sends it the signal.
  Ran ended_when(const std::string& condition, const std::string& signal,
                 const std::string& arguments) const {
    return shell("env --default-signal=INT " GAITSLAM_PROGRAM " " + arguments +
                 " & command=$!; while kill -0 $command && ! { " + condition +
                 "; }; do sleep 0.02; done 2>/dev/null; kill -" + signal + " $command; wait $command");
  }
  void ok(const std::string& arguments) const {
    const Ran ran = gaitslam(arguments);
    ASSERT_EQ(ran.exit_code, 0) << ran.err;
  }
  /// Every file that a result lists exists.
  void expect_whole(const std::string& result) const {
    std::istringstream lines(text_of(result + "/.gaitslam"));
    int listed = 0;
    for (std::string line; std::getline(lines, line); ++listed)
      if (!line.starts_with('#')) {
        EXPECT_TRUE(fs::exists(folder_ / result / line)) << result << ": " << line;
      }
    EXPECT_GT(listed, 10) << result;
  }
  /// Partial files and folders below a folder.
  std::vector<std::string> partial(const std::string& folder) const {
    std::vector<std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / folder))
      if (entry.path().filename().string().find(".partial") != std::string::npos) all.push_back(entry.path());
    return all;
  }
};

TEST_F(Interruption, AnOldResultStaysUntilTheNewOneIsWhole) {
  ok(kBlind + "--seeds 1..3 --out h");
  for (const char* when : {"[ -e h/.unfinished ]", "[ -e h/.seed-1.partial ]", "[ -e h/.seed-2.partial ]"}) {
    ended_when(when, "KILL", kBlind + "world.floor_friction=0.2 --seeds 1..3 --out h --force");
    for (const char* seed : {"h/seed-1", "h/seed-2", "h/seed-3"}) expect_whole(seed);
  }
}

TEST_F(Interruption, SeedsThatCrashLeaveNoOlderResultsBehind) {
  ok(kBlindStand + "--seeds 1,2 --out h");
  const Ran ran = shell("ulimit -t 1; " GAITSLAM_PROGRAM " " + kBlindStand +
                        "'walk.commands=[{stand: {duration_s: 300}}]' --seeds 1,2 --out h --force");
  EXPECT_EQ(ran.exit_code, 3) << ran.out << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("results of an earlier command are now in h/earlier-1: seed-1, seed-2"));
  EXPECT_THAT(ran.err, HasSubstr("seeds 1, 2: killed by signal"));
  EXPECT_THAT(ran.out, testing::ContainsRegex("failed +crashed +seeds 1, 2"));
  EXPECT_THAT(text_of("h/summary.json"), HasSubstr("\"ending\": \"crashed\""));
  EXPECT_FALSE(fs::exists(folder_ / "h/seed-1"));
  EXPECT_TRUE(fs::exists(folder_ / "h/earlier-1/seed-1/score.json"));
  EXPECT_THAT(partial("h"), IsEmpty());
}

TEST_F(Interruption, FewerSeedsThanBeforeLeaveNoStaleOnes) {
  ok(kBlindStand + "--seeds 1..3 --out h");
  const Ran fewer = gaitslam(kBlindStand + "--seeds 1 --out h --force");
  ASSERT_EQ(fewer.exit_code, 0) << fewer.err;
  EXPECT_THAT(fewer.out, HasSubstr("results of an earlier command are now in h/earlier-1: seed-2, seed-3\n"));
  EXPECT_THAT(fewer.out, HasSubstr("walk, 1 seed\n"));
  EXPECT_EQ(tests::json_of(folder_ / "h/summary.json")["seeds"].size(), 1u);
  ok("report h --out h.html");
  EXPECT_THAT(text_of("h.html"), Not(HasSubstr("seed 2")));
  EXPECT_TRUE(fs::exists(folder_ / "h/earlier-1/seed-3/score.json"));
  ok(kBlindStand + "--seeds 2 --out h --force");
  EXPECT_TRUE(fs::exists(folder_ / "h/earlier-2/seed-1/score.json"));
}

TEST_F(Interruption, KilledSeedsGoOnByTheSameCommand) {
  const std::string run = kBlind + "--seeds 1..4 --out ";
  ok(run + "whole");
  EXPECT_EQ(gaitslam(run + "whole").exit_code, 2) << "it was finished";
  ended_when("[ -e killed/.seed-1.partial ]", "KILL", run + "killed");
  ended_when("[ -e killed/seed-2 ]", "KILL", run + "killed");
  EXPECT_EQ(gaitslam(kBlind + "--seeds 1..5 --out killed").exit_code, 2) << "another command";
  const auto made = fs::last_write_time(folder_ / "killed/seed-1/score.json");
  const Ran last = gaitslam(run + "killed");
  ASSERT_EQ(last.exit_code, 0) << last.err;
  EXPECT_THAT(last.out, HasSubstr("finished before\n"));
  EXPECT_EQ(fs::last_write_time(folder_ / "killed/seed-1/score.json"), made) << "it was whole";
  EXPECT_THAT(differences(folder_ / "whole", folder_ / "killed"), IsEmpty());
  EXPECT_THAT(partial("killed"), IsEmpty());
}

// The estimator appends to the file `ran`.
TEST_F(Interruption, OlderResultsAreNotTakenForThoseOfTheInterruptedCommand) {
  fs::copy(std::string(GAITSLAM_SOURCE_DIR) + "/tools/examples/gyro_and_plan.py", folder_ / "gyro.py");
  const std::string run =
      "run walk.yaml 'estimator={program: [/usr/bin/python3, gyro.py]}' --seeds 1,2 --out h --force";
  ok(run);
  ASSERT_EQ(
      shell("echo 'open(\"ran\", \"a\").write(\"x\")' | cat - gyro.py > new && mv new gyro.py").exit_code, 0);
  ended_when("[ -e h/.unfinished ]", "KILL", run);
  fs::remove(folder_ / "ran");
  const Ran again = gaitslam(run);
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.out, Not(HasSubstr("finished before")));
  EXPECT_EQ(text_of("ran"), "xx");
}

TEST_F(Interruption, WithOtherModelsItIsAnotherCommand) {
  for (const char* models : {"m", "m2"})
    fs::copy(std::string(GAITSLAM_SOURCE_DIR) + "/models", folder_ / models);
  ASSERT_EQ(shell("echo '<!-- other -->' >> m2/office.xml").exit_code, 0);
  const std::string blind = kBlind + "--seeds 1..3 --out h ";
  ended_when("[ -e h/seed-2 ]", "KILL", blind + "--models m");
  EXPECT_EQ(gaitslam(blind + "--models m2").exit_code, 2);
  const Ran other = gaitslam(blind + "--models m2 --force");
  EXPECT_EQ(other.exit_code, 0) << other.err;
  EXPECT_THAT(other.out, Not(HasSubstr("finished before")));
}

TEST_F(Interruption, AFolderWithNothingButLeftoversDoesNotBlock) {
  for (const std::string& command : {kBlind + "--out h", kBlind + "--seeds 1,2 --out h"}) {
    ended_when("[ -e h/.seed-1.partial/recording ]", "KILL", command);
    ASSERT_FALSE(fs::exists(folder_ / "h/seed-1"));
    EXPECT_THAT(partial("h"), Not(IsEmpty()));
    ok(command);
    EXPECT_THAT(partial("h"), IsEmpty());
    fs::remove_all(folder_ / "h");
  }
}

TEST_F(Interruption, OnlyLeftoversInTheTemporaryFolderGoWithTheNextStart) {
  ok(kBlindStand + "--seeds 1,2 --out tmp/gaitslam-result");
  write("tmp/gaitslam-letter/dear.txt", "mine");
  ::setenv("TMPDIR", (folder_ / "tmp").c_str(), 1);
  const std::string run = kBlind + "--seeds 1,2 --out ";
  ended_when("[ -e h/.seed-1.partial ]", "KILL", run + "h");
  EXPECT_GT(std::distance(fs::directory_iterator(folder_ / "tmp"), {}), 2);
  ok(run + "again");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "tmp"), {}), 2);
  EXPECT_EQ(text_of("tmp/gaitslam-letter/dear.txt"), "mine");
  EXPECT_TRUE(fs::exists(folder_ / "tmp/gaitslam-result/seed-1/score.json"));
  ::setenv("TMPDIR", "/no such folder", 1);
  EXPECT_EQ(refusal(run + "none"),
            "gaitslam: TMPDIR: /no such folder: expected a folder for temporary files\n");
  ::unsetenv("TMPDIR");
}

TEST_F(Interruption, OfTwoCommandsOnOneFolderTheSecondIsRefused) {
  const std::string longer =
      "run walk.yaml 'walk.commands=[{stand: {duration_s: 300}}]' --without camera,slam ";
  const auto second = [&](const std::string& first, const std::string& until, const std::string& then) {
    return shell(GAITSLAM_PROGRAM " " + longer + first + " & first=$!; until [ -e " + until +
                 " ]; do sleep 0.02; done; " GAITSLAM_PROGRAM " " + then +
                 "; code=$?; kill -9 $first; exit $code");
  };
  const Ran seeds =
      second("--seeds 1,2 --out h", "h/.seed-1.partial", kBlind + "--seeds 1,2 --out h --force");
  EXPECT_EQ(seeds.exit_code, 2);
  EXPECT_THAT(seeds.err,
              HasSubstr("h: another process is writing there: wait for it, or name another folder"));
  const Ran one = second("--out k", "k/.seed-1.partial/recording", kBlind + "--out k --force");
  EXPECT_EQ(one.exit_code, 2);
  EXPECT_THAT(one.err, HasSubstr("k/seed-1: is being written by another process: wait for it"));
}

TEST_F(Interruption, ItIsSaidWhatIsKept) {
  const std::string seeds = kBlind + "--seeds 1..50 --out h";
  EXPECT_THAT(
      ended_when("[ -e h/.seed-1.partial ]", "INT", seeds).err,
      HasSubstr("gaitslam: interrupted: finished results are kept in h; to resume:\n  " GAITSLAM_PROGRAM " " +
                seeds + "\n"));
  const Ran one = ended_when("[ -e k/.seed-1.partial ]", "INT",
                             "run walk.yaml 'walk.commands=[{stand: {duration_s: 300}}]' --out k");
  EXPECT_THAT(one.err,
              HasSubstr("gaitslam: interrupted: nothing of this run is kept; earlier results in k are"));
  EXPECT_EQ(one.exit_code, 130);
  EXPECT_THAT(ended_when("[ -e s/trials.jsonl ]", "TERM",
                         "sweep walk.yaml 'slam.vision.sigma_px={from: 1, to: 3, points: 50}' --out s")
                  .err,
              HasSubstr("finished results are kept in s; to resume"));
}

}  // namespace
