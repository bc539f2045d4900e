#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/files/atomic_file.h"
#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::files {
namespace {

namespace fs = std::filesystem;
using testing::AllOf, testing::HasSubstr;

class OutputManifest : public testing::Test {
 protected:
  // A folder as the program makes them: result/score.json and result/recording/frames.csv.
  void make(const std::string& text = "made") const {
    AtomicFolder result(folder_ / "result/", Existing::replace);  // a trailing slash means the same folder
    write_text(result.path() / "score.json", text);
    fs::create_directory(result.path() / "recording");
    write_text(result.path() / "recording/frames.csv", text);
    result.commit();
  }
  void write(const std::string& name, const std::string& text = "mine") const {
    fs::create_directories((folder_ / name).parent_path());
    write_text(folder_ / name, text);
  }
  // Making the folder again fails with these words, and its content stays.
  void expect_spared(const std::string& words) const {
    EXPECT_THAT(error_of([&] { make("again"); }), AllOf(HasSubstr(words), HasSubstr("move it away")));
    if (fs::exists(folder_ / "result/score.json")) {
      EXPECT_EQ(read_text(folder_ / "result/score.json"), "made");
    }
  }
  const TemporaryFolder folder_;
};

TEST_F(OutputManifest, WhatTheProgramMadeIsReplaced) {
  make();
  EXPECT_EQ(unlisted_in(folder_ / "result"), std::nullopt);
  EXPECT_EQ(read_text(folder_ / "result" / kMarker),
            "# Made by gaitslam, which replaces and removes only what is listed here.\n"
            "recording/\nrecording/frames.csv\nscore.json\n");
  EXPECT_THAT(error_of([&] { AtomicFolder rejected(folder_ / "result"); }), HasSubstr("exists already"));
  list_outputs(folder_ / "result", {"old"});
  write("result/old");
  write("result/..gaitslam.partial", "left by a killed process");
  make("again");
  EXPECT_FALSE(fs::exists(folder_ / "result/old"));
  EXPECT_EQ(read_text(folder_ / "result/score.json"), "again");
  EXPECT_FALSE(fs::exists(folder_ / "result/..gaitslam.partial"));
}

TEST_F(OutputManifest, AFolderOfTheUsersIsNotReplacedUnlessItIsEmpty) {
  write("result/letter.txt");
  expect_spared("result: would be replaced with letter.txt in it");
  EXPECT_EQ(read_text(folder_ / "result/letter.txt"), "mine");
  fs::remove(folder_ / "result/letter.txt");
  make();
  EXPECT_TRUE(has_marker(folder_ / "result"));
}

TEST_F(OutputManifest, ANoteInIsSparedAndNamed) {
  for (const std::string note : {"result/notes.txt", "result/recording/notes.txt", "result/mine/notes.txt",
                                 "result/mine/.gaitslam", ".result.partial/letter.txt"}) {
    if (!note.starts_with('.')) make();
    write(note);
    expect_spared((note.find("mine") != note.npos ? "result/mine"
                   : note.starts_with('.')        ? ".result.partial"
                                                  : note) +
                  std::string(": was not made by gaitslam"));
    EXPECT_EQ(read_text(folder_ / note), "mine");
    fs::remove_all(folder_ / "result");
  }
}

TEST_F(OutputManifest, FoldersThatTheProgramAddedLaterAreItsOwn) {
  make();
  for (const char* later : {"result/replay", "result/export/euroc"}) {
    AtomicFolder added(folder_ / later);
    write_text(added.path() / "data.csv", "x");
    added.commit();
  }
  add_to_marker(folder_ / "result", {"replay/", "export/", "export/euroc/"});
  list_outputs(folder_ / "result", {"video.mp4"});
  write("result/video.mp4");
  write("result/.score.json.partial");
  EXPECT_EQ(unlisted_in(folder_ / "result"), std::nullopt);
  write("result/export/euroc/notes.txt");
  EXPECT_EQ(unlisted_in(folder_ / "result"), folder_ / "result/export/euroc/notes.txt");
}

TEST_F(OutputManifest, LinksAreNeitherFollowedNorRemoved) {
  write("precious/letter.txt");
  make();
  fs::create_directory_symlink(folder_ / "precious", folder_ / "result/link");
  expect_spared("result/link: was not made by gaitslam");
  fs::remove(folder_ / "result/link");
  fs::remove_all(folder_ / "result/recording");
  fs::create_directory_symlink(folder_ / "precious", folder_ / "result/recording");
  expect_spared("result/recording: was not made by gaitslam");
  fs::remove_all(folder_ / "result");
  fs::create_directory_symlink(folder_ / "precious", folder_ / "result");
  EXPECT_THAT(error_of([&] { make(); }), HasSubstr("result: is a symbolic link"));
  EXPECT_EQ(read_text(folder_ / "precious/letter.txt"), "mine");
}

TEST_F(OutputManifest, AMarkerThatIsALinkOrOfSomethingElseIsNone) {
  make();
  fs::rename(folder_ / "result" / kMarker, folder_ / "marker");
  fs::create_symlink(folder_ / "marker", folder_ / "result" / kMarker);
  EXPECT_FALSE(has_marker(folder_ / "result"));
  fs::remove(folder_ / "result" / kMarker);
  write("result/.gaitslam", "score.json\n");
  expect_spared("result: would be replaced with ");
  expect_spared("(older versions wrote none): move it away");
}

// While a result is being made the user puts a file into the one that it replaces.
TEST_F(OutputManifest, WhatAppearsInTheOldOneMeanwhileIsKept) {
  make();
  AtomicFolder result(folder_ / "result", Existing::replace);
  write_text(result.path() / "score.json", "again");
  write("result/notes.txt");
  EXPECT_THAT(error_of([&] { result.commit(); }), HasSubstr("is kept in "));
  EXPECT_EQ(read_text(folder_ / "result/score.json"), "again");
  EXPECT_EQ(read_text(folder_ / "result.replaced/score.json"), "made");
  EXPECT_EQ(read_text(folder_ / "result.replaced/notes.txt"), "mine");
}

TEST_F(OutputManifest, NamesAreClaimedUnlessSomebodyElseHasThem) {
  const fs::path root = folder_ / "root";
  list_outputs(root, {"summary.json", "parts/"});
  write("root/summary.json", "ours");
  list_outputs(root, {"summary.json", "index.html"});
  write("root/parts");
  EXPECT_THAT(error_of([&] { list_outputs(root, {"parts/"}); }), HasSubstr("parts: was not made"))
      << "a file, not a folder";
  fs::remove(root / "parts");
  write("root/report.html");
  EXPECT_THAT(error_of([&] {
                list_outputs(root, {"tune.json", "report.html"});
              }),
              HasSubstr("report.html: was not made by this version of gaitslam"));
  EXPECT_EQ(read_text(root / kMarker).find("tune.json"), std::string::npos) << "nothing was changed";
  EXPECT_EQ(unlisted_in(root), root / "report.html");
  fs::remove(root / "report.html");
  EXPECT_EQ(unlisted_in(root), std::nullopt);
}

TEST_F(OutputManifest, NamesThatWereClaimedAndNotWrittenAreFreeAgain) {
  const fs::path root = folder_ / "root";
  list_outputs(root, {"summary.json", "best.yaml", "parts/"});
  write("root/summary.json", "ours");
  unlist_missing(root, {"summary.json", "best.yaml", "parts/"});
  EXPECT_EQ(listed_in(root), OutputNames{"summary.json"});
  write("root/best.yaml");
  EXPECT_THAT(error_of([&] { list_outputs(root, {"best.yaml"}); }), HasSubstr("best.yaml: was not made"));
  fs::remove(root / "summary.json");
  unlist_missing(root, {"summary.json"});
  EXPECT_FALSE(fs::exists(root / kMarker)) << "it lists nothing";
}

}  // namespace
}  // namespace sim::files
