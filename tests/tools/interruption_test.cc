// Interrupted and repeated commands: old results stay until new ones are complete, and a rerun resumes. Only
// folders created by gaitslam are replaced.
#include "tests/tools/command_line.h"

namespace tests {
namespace {

class Interruption : public CommandLine {
 protected:
  Interruption() { write("stand.yaml", kStand + "name: walk\n"); }

  /// Partial files and folders below a folder.
  std::vector<std::string> partial(const std::string& folder) const {
    std::vector<std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / folder))
      if (entry.path().filename().string().find(".partial") != std::string::npos) all.push_back(entry.path());
    return all;
  }
};

TEST_F(Interruption, ASeedThatCrashesHasNoScoreThoughAnOlderResultStays) {
  ok(kBlindStand + "--seeds 1,2 --out h");
  const Ran ran = shell("ulimit -t 2; " GAITSLAM_PROGRAM " " + kBlindStand +
                        "'walk.commands=[{stand: {duration_s: 300}}]' --seeds 1,2 --out h --force")
                      .ends(3);
  EXPECT_THAT(ran.err, Has("seeds 1, 2: killed by signal"));
  EXPECT_EQ(ran.err.find("killed"), ran.err.rfind("killed")) << "a message that seeds share appears once";
  EXPECT_THAT(ran.out, ContainsRegex("failed +crashed +seeds 1, 2"));
  EXPECT_THAT(text_of("h/summary.json"), Has("\"ending\": \"crashed\""));
  EXPECT_TRUE(fs::exists(folder_ / "h/seed-1/score.json"));
}

TEST_F(Interruption, SeedsAreAddedOnlyToThoseWithTheSameSettings) {
  const auto seeds = [&] { return json_in("h/summary.json")["seeds"].size(); };
  ok(kBlindStand + "seed=1 --out h");
  ok(kBlindStand + "seed=2 --out h");
  EXPECT_THAT(ok(kBlindStand + "--seeds 1..3 --out h"),
              Has("2 results finished before\n", "walk, 3 seeds\n"));
  EXPECT_THAT(ok(kBlindStand + "--seeds 4 --out h"), Has("walk, 4 seeds\n"));
  EXPECT_EQ(seeds(), 4u);
  ok(kBlindStand + "seed=7 --out h");
  EXPECT_EQ(seeds(), 5u) << "a single run renews the summary";
  expect_refused(kBlindStand + "seed=7 --out h", "h/seed-7: already exists; --force replaces it");

  for (const char* name : {"seed-07", "seed-+3", "seed-x"})  // names that the program does not use
    write(std::string("h/") + name + "/score.json", "{}");
  const std::string slippery = kBlindStand + "world.floor_friction=0.2 ";
  for (const char* other : {"--seeds 8", "seed=8"})
    expect_refused(
        slippery + other + " --out h",
        "h/seed-1: exists, but world.floor_friction is 0.15 there and 0.2 here; --force replaces it, "
        "--out names another folder");
  ok(slippery + "seed=8 --out h --force");
  EXPECT_EQ(seeds(), 1u) << "seeds with the same settings";
  EXPECT_THAT(ok(slippery + "--seeds 2,9 --out h --force"), Has("walk, 3 seeds\n"));
  EXPECT_THAT(text_of("h/seed-1/scenario.yaml"), Lacks("floor_friction: 0.2")) << "it was not named";
}

TEST_F(Interruption, KilledSeedsAreResumedByTheSameCommand) {
  const std::string run = kBlind + "--seeds 1..4 --out ";
  ok(run + "whole");
  ended_when("[ -e killed/.seed-1.partial ]", "KILL", run + "killed");
  ended_when("[ -e killed/seed-2 ]", "KILL", run + "killed");
  const auto made = fs::last_write_time(folder_ / "killed/seed-1/score.json");
  EXPECT_THAT(ok(run + "killed --force"), Has("finished before\n")) << "also with --force";
  EXPECT_EQ(fs::last_write_time(folder_ / "killed/seed-1/score.json"), made) << "it was whole";
  EXPECT_THAT(differences(folder_ / "whole", folder_ / "killed"), IsEmpty());
  EXPECT_THAT(partial("killed"), IsEmpty());
}

// The estimator appends to the file `ran`.
TEST_F(Interruption, ResultsOfExternalProgramsAreMadeAgainByForceAndKeptOnlyIfTheProgramIsTheSame) {
  fs::copy(kSources + "/tools/examples/gyro_and_plan.py", folder_ / "gyro.py");
  const std::string run =
      "run walk.yaml 'estimator={program: [/usr/bin/python3, gyro.py]}' --seeds 1,2 --out h ";
  ok(run);
  shell("echo 'open(\"ran\", \"a\").write(\"x\")' | cat - gyro.py > new && mv new gyro.py");
  expect_refused(run, "h/seed-1: exists, but its programs' hash is ");
  for (const char* times : {"xx", "xxxx"}) {
    EXPECT_THAT(ok(run + "--force"), Lacks("finished before"));
    EXPECT_EQ(text_of("ran"), times);
  }
  EXPECT_THAT(ok(run), Has("2 results finished before"));
}

TEST_F(Interruption, OnlyLeftoversInTheTemporaryFolderAreRemovedAtTheNextStart) {
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
            "gaitslam: TMPDIR: /no such folder: is not a folder, expected one for temporary files\n");
  ::unsetenv("TMPDIR");
}

constexpr const char* kLong = "run walk.yaml 'walk.commands=[{stand: {duration_s: 300}}]' ";

TEST_F(Interruption, TheSecondOfTwoCommandsOnOneFolderIsRefused) {
  const Ran ran = shell(GAITSLAM_PROGRAM " " + std::string(kLong) +
                        "--seeds 1,2 --out h --without camera,slam & first=$!; until [ -e h/.seed-1.partial "
                        "]; do sleep 0.02; done; " GAITSLAM_PROGRAM " " +
                        kBlind + "--seeds 1,2 --out h --force; code=$?; kill -9 $first; exit $code");
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_THAT(ran.err, Has("h: another process is writing there; wait for it, or choose another folder"));
}

TEST_F(Interruption, ReportsWhatIsKept) {
  const std::string seeds = kBlind + "--seeds 1..50 --out h";
  EXPECT_THAT(
      ended_when("[ -e h/.seed-1.partial ]", "INT", seeds).err,
      Has("gaitslam: interrupted: finished results are kept in h; to resume:\n  " GAITSLAM_PROGRAM " " +
          seeds + "\n"));
  const Ran one = ended_when("[ -e k/.seed-1.partial ]", "INT", std::string(kLong) + "--out k");
  EXPECT_THAT(one.err, Has("gaitslam: interrupted: this run leaves no result; earlier results in k are"));
  EXPECT_EQ(one.exit_code, 130);
  EXPECT_THAT(ended_when("[ -e s/trials.jsonl ]", "TERM",
                         "sweep walk.yaml 'slam.vision.sigma_px={from: 1, to: 3, points: 50}' --out s")
                  .err,
              Has("finished results are kept in s; to resume"));
}

class OwnFiles : public CommandLine {
 protected:
  OwnFiles() { write("walk.yaml", kStand); }
  void run(const std::string& arguments) const { ok("run walk.yaml " + arguments); }
  /// Expects that the command is rejected with this message and changes no file of the folder.
  void expect_spared(const std::string& arguments, const std::string& folder,
                     const std::string& named) const {
    const auto before = files(folder_ / folder);
    EXPECT_THAT(refusal(arguments), Has(named)) << arguments;
    EXPECT_THAT(differences(before, files(folder_ / folder)), IsEmpty()) << arguments;
  }
};

TEST_F(OwnFiles, ForceReplacesNoFolderAndNoFileOfTheUser) {
  run("--out one");
  write("home/letter.txt", "dear");
  for (const char* name : {"summary.json", "trials.jsonl", "scores.csv"})
    write(std::string("home/") + name, "mine");
  write("home/seed-1/diary.txt", "mine");
  fs::create_directory_symlink(folder_ / "home", folder_ / "link");
  for (const auto& [command, named] : std::vector<std::pair<std::string, std::string>>{
           {"replay one/seed-1 --out home", "home: was not created by gaitslam"},
           {"export one/seed-1 --format tum --out home", "home: was not created by gaitslam"},
           {"report one/seed-1 --plots svg --out home", "home: was not created by gaitslam"},
           {"replay one/seed-1 --out link", "link: is a symbolic link"},
           {kBlind + "--seeds 2,3 --out home", "home: was not created by gaitslam"},
           {kBlind + "--out home", "home: was not created by gaitslam"}})
    expect_spared(command + " --force", "home", named);
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_THAT(gaitslam("sweep walk.yaml slam.vision.sigma_px=1,2 --out home --force").ends(2).err,
              Has("home: was not created by gaitslam"));
}

TEST_F(OwnFiles, VerdictsReplaceOnlyThoseOfAnEarlierCall) {
  run("--without camera,slam --out one");
  for (const std::string option : {"--json", "--junit", "--markdown"}) {
    const std::string compare = "compare one/seed-1 one/seed-1 " + option + " verdicts";
    ok(compare);
    const std::string verdicts = text_of("verdicts");
    for (const std::string& replaced : {std::string(), verdicts}) {
      write("verdicts", replaced);
      ok(compare);
      EXPECT_EQ(text_of("verdicts"), verdicts);
    }
    write("verdicts", "### my notes");
    expect_refused(compare, "verdicts: exists and was not written by gaitslam");
    EXPECT_EQ(text_of("verdicts"), "### my notes");
    fs::remove(folder_ / "verdicts");
  }
}

TEST_F(OwnFiles, NeitherInputsNorTheCurrentFolderAreReplaced) {
  run("--out one");
  for (const std::string command : {"replay one/seed-1 --out one/seed-1 --force",
                                    "report one/seed-1 --plots svg --out one/seed-1 --force"})
    expect_spared(command, "one", "would be replaced, but the command reads one/seed-1");
  for (const std::string command : {"replay ../one/seed-1", "report ../one/seed-1 --plots svg --force"})
    for (const std::string out : {".", "\"$PWD\"", "../here"}) {
      const Ran ran =
          shell("rm -rf here; mkdir here; cd here; " GAITSLAM_PROGRAM " " + command + " --out " + out);
      EXPECT_EQ(ran.exit_code, 2) << command << out;
      EXPECT_THAT(ran.err, Has(": would be replaced, but is or contains the current folder"));
      EXPECT_TRUE(fs::is_empty(folder_ / "here"));
    }
}

}  // namespace
}  // namespace tests
