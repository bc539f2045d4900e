// User files are never replaced: a folder is replaced only if gaitslam made all files in it.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/sim/result/result_folder.h"
#include "tests/tools/command_line.h"

namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using tests::kBlind;
using tests::Ran;

class OwnFiles : public tests::CommandLineWithCache {
 protected:
  OwnFiles() { write("walk.yaml", tests::kStand); }
  void run(const std::string& arguments) const {
    const Ran ran = gaitslam("run walk.yaml " + arguments);
    ASSERT_EQ(ran.exit_code, 0) << ran.err;
  }
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
    ASSERT_EQ(gaitslam(compare).exit_code, 0) << option;
    const std::string verdicts = text_of("verdicts");
    write("verdicts", "");
    EXPECT_EQ(gaitslam(compare).exit_code, 0) << option << " replaces an empty file";
    EXPECT_EQ(gaitslam(compare).exit_code, 0) << option << " replaces what it wrote";
    EXPECT_EQ(text_of("verdicts"), verdicts);
    write("verdicts", "### my notes");
    EXPECT_THAT(refusal(compare), HasSubstr("verdicts: exists and was not written by gaitslam")) << option;
    EXPECT_EQ(text_of("verdicts"), "### my notes");
    fs::remove(folder_ / "verdicts");
  }
}

TEST_F(OwnFiles, NotesInTheFoldersOfAResultAreSpared) {
  run("");
  const std::string result = "results/walk/seed-1";
  ASSERT_EQ(gaitslam("replay " + result).exit_code, 0);
  ASSERT_EQ(gaitslam("export " + result + " --format tum").exit_code, 0);
  EXPECT_EQ(gaitslam("replay " + result).exit_code, 0);
  EXPECT_EQ(gaitslam("export " + result + " --format tum").exit_code, 0);
  EXPECT_EQ(gaitslam(kBlind).exit_code, 0) << "with a replay and an export in it all is still gaitslam's";

  run("");
  ASSERT_EQ(gaitslam("replay " + result).exit_code, 0);
  ASSERT_EQ(gaitslam("export " + result + " --format tum").exit_code, 0);
  write(result + "/replay/notes.txt", "mine");
  write(result + "/export/tum/notes.txt", "mine");
  for (const std::string force : {"", " --force"}) {
    expect_spared("replay " + result + force, "results", "replay/notes.txt: was not made by gaitslam");
    expect_spared("export " + result + " --format tum" + force, "results", "tum/notes.txt: was not made");
    expect_spared(kBlind + force, "results", "notes.txt: was not made by gaitslam");
    expect_spared(kBlind + "--seeds 1,2" + force, "results", "notes.txt: was not made by gaitslam");
  }
  fs::remove(folder_ / result / "replay/notes.txt");
  EXPECT_EQ(gaitslam("replay " + result).exit_code, 0);
}

TEST_F(OwnFiles, WhatIsReadIsNotReplaced) {
  run("--out one");
  for (const std::string command : {"replay one/seed-1 --out one/seed-1 --force",
                                    "export one/seed-1 --format tum --out one/seed-1/. --force",
                                    "report one/seed-1 --plots svg --out one/seed-1 --force"})
    expect_spared(command, "one", "would be replaced, and the command reads one/seed-1");
}

TEST_F(OwnFiles, TheCurrentFolderIsNotReplaced) {
  run("--out one");
  for (const std::string command : {"replay ../one/seed-1", "export ../one/seed-1 --format tum",
                                    "report ../one/seed-1 --plots svg --force"})
    for (const std::string out : {".", "./", "\"$PWD\"", "../here"}) {
      const Ran ran =
          shell("rm -rf here; mkdir here; cd here; " GAITSLAM_PROGRAM " " + command + " --out " + out);
      EXPECT_EQ(ran.exit_code, 2) << command << out;
      EXPECT_THAT(
          ran.err,
          HasSubstr(": is or contains the current folder, and would be replaced; name another folder"));
      EXPECT_TRUE(fs::is_empty(folder_ / "here"));
    }
}

TEST_F(OwnFiles, NothingButRegularFilesIsReplaced) {
  run("--without camera,slam --out one");
  ASSERT_EQ(shell("mkfifo pipe.mp4 && ln -s pipe.mp4 link.mp4").exit_code, 0);
  for (const std::string command :
       {"report one/seed-1 --force --out ", "leaderboard one --force --csv ",
        "leaderboard one --force --html ", "video one/seed-1 --force --out ",
        "compare one/seed-1 one/seed-1 --json ", "compare one/seed-1 one/seed-1 --junit ",
        "compare one/seed-1 one/seed-1 --markdown "})
    for (const std::string file : {"pipe.mp4", "link.mp4"}) {
      const Ran ran = shell("timeout 20 " GAITSLAM_PROGRAM " " + command + file);
      EXPECT_EQ(ran.exit_code, 2) << command << file;
      EXPECT_EQ(ran.err, "gaitslam: " + file + ": cannot be written: it is not a regular file\n") << command;
      EXPECT_TRUE(fs::is_fifo(folder_ / "pipe.mp4") && fs::is_symlink(folder_ / "link.mp4"))
          << command << file;
    }
}

TEST_F(OwnFiles, ARecordingIsTheSameBytesTwiceAndNamesTheScenarioAsGiven) {
  const auto recorded = [this](const std::string& cache, const std::string& command) {
    const Ran ran = shell("GAITSLAM_CACHE='" + cache + "' " GAITSLAM_PROGRAM " " + command);
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    auto all = tests::files(folder_ / cache);
    std::erase_if(all, [](const auto& file) { return file.first.ends_with(".lock"); });
    return all;
  };
  const auto first = recorded("a", "record walk.yaml --seeds 1,2 --jobs 2"),
             by_runs = recorded("c", "run walk.yaml --seeds 1,2 --cached");
  EXPECT_THAT(tests::differences(first, by_runs), IsEmpty());
  int compared = 0;
  for (const auto& [name, bytes] : first)
    if (name.ends_with("about.json")) {
      EXPECT_THAT(bytes, HasSubstr("\"walk.yaml:"));
      EXPECT_THAT(bytes, Not(HasSubstr("/gaitslam-")));
      ++compared;
    }
  EXPECT_EQ(compared, 2);
}

}  // namespace
