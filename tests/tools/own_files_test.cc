// User files are never replaced: a folder is replaced only if gaitslam made all files in it.
#include <gmock/gmock.h>

#include "tests/sim/result/result_folder.h"
#include "tests/tools/command_line.h"

namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using tests::kBlind;
using tests::Ran;

class OwnFiles : public tests::CommandLineWithCache {
 protected:
  OwnFiles() { write("walk.yaml", tests::kStand); }
  void run(const std::string& arguments) const { ok("run walk.yaml " + arguments); }
  /// The command is rejected with this message and changes no file of the folder.
  void expect_spared(const std::string& arguments, const std::string& folder,
                     const std::string& named) const {
    const auto before = tests::files(folder_ / folder);
    EXPECT_THAT(refusal(arguments), HasSubstr(named)) << arguments;
    EXPECT_THAT(tests::differences(before, tests::files(folder_ / folder)), IsEmpty()) << arguments;
  }
};

TEST_F(OwnFiles, ForceEmptiesNoFolderOfTheUser) {
  run("--out one");
  write("home/letter.txt", "dear");
  write("home/photos/cat.png", "meow");
  for (const std::string command :
       {"replay one/seed-1 --out home --force", "replay one/seed-1 --out home/ --force",
        "export one/seed-1 --format tum --out home --force",
        "report one/seed-1 --plots svg --out home --force"})
    expect_spared(command, "home", "home: would be replaced with letter.txt in it");
  fs::create_directory_symlink(folder_ / "home", folder_ / "link");
  for (const std::string command :
       {"replay one/seed-1 --out link --force", "export one/seed-1 --format tum --out link --force"})
    expect_spared(command, "home", "link: is a symbolic link");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
}

TEST_F(OwnFiles, ForceOverwritesNoFileThatOtherCommandsWouldWrite) {
  for (const char* name : {"summary.json", "trials.jsonl", "scores.csv", "report.html", "index.html"})
    write(std::string("home/") + name, "mine");
  write("home/parts/engine.txt", "mine");
  write("home/seed-1/diary.txt", "mine");
  expect_spared(kBlind + "--seeds 2,1 --out home --force", "home", "home/seed-1: would be replaced");
  expect_spared(kBlind + "--out home --force", "home", "home/seed-1: would be replaced with diary.txt in it");
  const Ran sweep = gaitslam("sweep walk.yaml slam.vision.sigma_px=1,2 --out home --force");
  EXPECT_EQ(sweep.exit_code, 2);
  EXPECT_THAT(sweep.err, HasSubstr("home/trials.jsonl: was not made by this version of gaitslam"));
  EXPECT_EQ(text_of("home/parts/engine.txt"), "mine");
  fs::remove_all(folder_ / "home/seed-1");
  expect_spared(kBlind + "--seeds 1,2 --out home --force", "home", "home/summary.json: was not made");
}

TEST_F(OwnFiles, VerdictsReplaceThoseOfAnEarlierCallAlone) {
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

TEST_F(OwnFiles, NotesInTheFoldersOfAResultAreSpared) {
  const std::string replay = "replay results/walk/seed-1", to_tum = "export results/walk/seed-1 --format tum";
  run("");
  for (const std::string& command : {replay, to_tum, replay, to_tum}) ok(command);
  ok(kBlind);  // with a replay and an export in it all is still gaitslam's

  run("");
  for (const std::string& command : {replay, to_tum}) ok(command);
  write("results/walk/seed-1/replay/notes.txt", "mine");
  write("results/walk/seed-1/export/tum/notes.txt", "mine");
  for (const std::string force : {"", " --force"}) {
    expect_spared(replay + force, "results", "replay/notes.txt: was not made by gaitslam");
    expect_spared(to_tum + force, "results", "tum/notes.txt: was not made");
    expect_spared(kBlind + force, "results", "notes.txt: was not made by gaitslam");
    expect_spared(kBlind + "--seeds 1,2" + force, "results", "notes.txt: was not made by gaitslam");
  }
  fs::remove(folder_ / "results/walk/seed-1/replay/notes.txt");
  ok(replay);
}

TEST_F(OwnFiles, NeitherWhatIsReadNorTheCurrentFolderIsReplaced) {
  run("--out one");
  for (const std::string command : {"replay one/seed-1 --out one/seed-1 --force",
                                    "export one/seed-1 --format tum --out one/seed-1/. --force",
                                    "report one/seed-1 --plots svg --out one/seed-1 --force"})
    expect_spared(command, "one", "would be replaced, and the command reads one/seed-1");
  for (const std::string command : {"replay ../one/seed-1", "export ../one/seed-1 --format tum",
                                    "report ../one/seed-1 --plots svg --force"})
    for (const std::string out : {".", "\"$PWD\"", "../here"}) {
      const Ran ran =
          shell("rm -rf here; mkdir here; cd here; " GAITSLAM_PROGRAM " " + command + " --out " + out);
      EXPECT_EQ(ran.exit_code, 2) << command << out;
      EXPECT_THAT(ran.err, HasSubstr(": is or contains the current folder, and would be replaced"));
      EXPECT_TRUE(fs::is_empty(folder_ / "here"));
    }
}

TEST_F(OwnFiles, NothingButRegularFilesIsReplaced) {
  run("--without camera,slam --out one");
  shell("mkfifo pipe.mp4 && ln -s pipe.mp4 link.mp4");
  for (const std::string command :
       {"report one/seed-1 --force --out ", "leaderboard one --force --csv ",
        "video one/seed-1 --force --out ", "compare one/seed-1 one/seed-1 --json "})
    for (const std::string file : {"pipe.mp4", "link.mp4"}) {
      const Ran ran = shell("timeout 20 " GAITSLAM_PROGRAM " " + command + file);
      EXPECT_EQ(ran.exit_code, 2) << command << file;
      EXPECT_EQ(ran.err, "gaitslam: " + file + ": cannot be written: it is not a regular file\n") << command;
      EXPECT_TRUE(fs::is_fifo(folder_ / "pipe.mp4") && fs::is_symlink(folder_ / "link.mp4")) << command;
    }
}

}  // namespace
