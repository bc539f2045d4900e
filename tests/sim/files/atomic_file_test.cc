#include "sim/files/atomic_file.h"

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "tests/sim/files/temporary_folder.h"

namespace sim::files {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::vector<std::string> names(const fs::path& folder) {
  std::vector<std::string> all;
  for (const auto& entry : fs::directory_iterator(folder)) all.push_back(entry.path().filename().string());
  return all;
}

TEST(AtomicFile, ThatCannotBeWrittenIsNamedAndLeavesNothing) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { write_atomically(folder / "none" / "a.json", "x"); }),
              testing::AllOf(HasSubstr("none"), HasSubstr("No such file or directory")));
  fs::create_directory(folder / "taken");
  EXPECT_THAT(error_of([&] { write_atomically(folder / "taken", "x"); }),
              HasSubstr("taken: cannot be written"));
  EXPECT_THAT(names(folder.path()), testing::ElementsAre("taken"));
}

TEST(AtomicFile, ReplacesNothingButRegularFiles) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  fs::create_symlink("pipe", folder / "link");
  fs::create_symlink("/dev/null", folder / "null");
  for (const char* name : {"pipe", "link", "null"}) {
    const auto type = fs::symlink_status(folder / name).type();
    EXPECT_THAT(error_of([&] { write_atomically(folder / name, "x"); }),
                HasSubstr(std::string(name) + ": cannot be written: it is not a regular file"));
    EXPECT_EQ(fs::symlink_status(folder / name).type(), type);
  }
}

TEST(AtomicFile, KeepsThePermissionsOfTheFileThatItReplaces) {
  const TemporaryFolder folder;
  for (const fs::perms bits : {fs::perms(0600), fs::perms(0664), fs::perms(0400)}) {
    write_text(folder / "a", "x");
    fs::permissions(folder / "a", bits);
    write_atomically(folder / "a", "y");
    EXPECT_EQ(fs::status(folder / "a").permissions(), bits);
    EXPECT_EQ(read_text(folder / "a"), "y");
    fs::remove(folder / "a");
  }
}

TEST(AtomicFolder, AppearsOnlyByCommit) {
  const TemporaryFolder folder;
  { write_text(AtomicFolder(folder / "result").path() / "a", "x"); }
  EXPECT_TRUE(fs::is_empty(folder.path())) << "without commit";
  AtomicFolder result(folder / "parents/too/result");
  write_text(result.path() / "score.json", "{}");
  EXPECT_FALSE(fs::exists(folder / "parents/too/result"));
  EXPECT_EQ(result.path().parent_path(), folder / "parents/too") << "on the same file system";
  result.commit();
  EXPECT_EQ(read_text(folder / "parents/too/result/score.json"), "{}");
  EXPECT_TRUE(has_marker(folder / "parents/too/result"));
  EXPECT_THAT(names(folder / "parents/too"), testing::ElementsAre("result"));
}

TEST(AtomicFolder, DoesNotOverwriteWhatAppearedMeanwhile) {
  const TemporaryFolder folder;
  AtomicFolder result(folder / "result");
  fs::create_directory(folder / "result");
  write_text(folder / "result/other", "of another run");
  EXPECT_THAT(error_of([&] { result.commit(); }), HasSubstr("result: cannot be made"));
  EXPECT_EQ(read_text(folder / "result/other"), "of another run");
}

// Runs `work` in a child process that is killed before or after one of its system calls (two stops a call,
// from 0). False: it had ended by then.
template <typename Work>
bool killed_at(int stop, Work work) {
  const pid_t child = fork();
  if (child == 0) {
    ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
    raise(SIGSTOP);
    work();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  for (int k = 0; k <= stop; ++k) {
    if (ptrace(PTRACE_SYSCALL, child, nullptr, nullptr) != 0) throw std::runtime_error("cannot be traced");
    waitpid(child, &status, 0);
    if (WIFEXITED(status)) return false;
  }
  kill(child, SIGKILL);
  waitpid(child, &status, 0);
  return true;
}

TEST(AtomicFile, KilledAtEverySystemCallIsTheOldOneOrTheNew) {
  const TemporaryFolder folder;
  const std::string before = "before", after = "afterwards";
  int old = 0, renewed = 0, left = 0;
  for (int stop = 0;; ++stop) {
    write_atomically(folder / "a.json", before);
    EXPECT_THAT(names(folder.path()), testing::ElementsAre("a.json")) << "what a killed writer left is gone";
    if (!killed_at(stop, [&] { write_atomically(folder / "a.json", after); })) break;
    const std::string found = read_text(folder / "a.json");
    EXPECT_TRUE(found == before || found == after) << "stop " << stop << ": " << found;
    ++(found == after ? renewed : old);
    left += names(folder.path()).size() > 1;
  }
  EXPECT_GT(old, 5);
  EXPECT_GT(renewed, 1);
  EXPECT_GT(left, 1);
}

// First without a folder, then with that of an earlier run.
TEST(AtomicFolder, KilledAtEverySystemCallIsWholeOrAsBefore) {
  for (const bool replaces : {false, true}) {
    const TemporaryFolder folder;
    const auto make = [&](const std::string& text) {
      AtomicFolder result(folder / "result", Existing::replace);
      for (const char* name : {"a", "b", "c"}) write_text(result.path() / name, text);
      result.commit();
    };
    int before = 0, after = 0;
    for (int stop = 0;; ++stop) {
      for (const std::string& name : names(folder.path())) fs::remove_all(folder / name);
      if (replaces) make("old");
      if (!killed_at(stop, [&] { make("new"); })) break;
      if (!replaces && !fs::exists(folder / "result")) {
        ++before;
        continue;
      }
      const std::string of = read_text(folder / "result/a");
      EXPECT_TRUE(of == "new" || (replaces && of == "old")) << "stop " << stop << ": " << of;
      EXPECT_THAT(names(folder / "result"), testing::UnorderedElementsAre("a", "b", "c", kMarker))
          << "stop " << stop;
      EXPECT_EQ(unlisted_in(folder / "result"), std::nullopt) << "stop " << stop;
      for (const char* name : {"b", "c"})
        EXPECT_EQ(read_text(folder / "result" / name), of) << "stop " << stop;
      ++(of == "new" ? after : before);
    }
    EXPECT_GT(before, 10);
    EXPECT_GT(after, 1);
    killed_at(before - 1, [&] { make("new"); });
    EXPECT_GT(names(folder.path()).size(), 1u);
    make("last");
    EXPECT_THAT(names(folder.path()), testing::ElementsAre("result"));  // what the killed ones left is gone
  }
}

TEST(AtomicFolder, ASecondProcessIsRejectedAndTheFirstOneLeftAlone) {
  const TemporaryFolder folder;
  AtomicFolder first(folder / "result");
  write_text(first.path() / "a", "x");
  const pid_t second = fork();
  if (second == 0) {
    const std::string error = error_of([&] { AtomicFolder(folder / "result", Existing::replace); });
    _exit(error.find("is being written by another process") == error.npos);
  }
  int status = 0;
  waitpid(second, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  remove_leftovers(folder.path());
  first.commit();
  EXPECT_EQ(read_text(folder / "result/a"), "x");
}

TEST(AtomicFolder, LeftoversAreRemovedUnlessTheyCannotBeLocked) {
  const TemporaryFolder folder;
  fs::create_directory(folder / ".a.partial");
  write_text(folder / ".a.partial" / kMarker, "");
  fs::permissions(folder / ".a.partial" / kMarker, fs::perms::none);
  fs::permissions(folder.path(), fs::perms::all);
  const AsUser user;
  fs::create_directory(folder / ".b.partial");
  write_text(folder / ".b.partial" / kMarker, "");
  remove_leftovers(folder.path());
  EXPECT_THAT(names(folder.path()), testing::ElementsAre(".a.partial"));
}

TEST(AtomicFolder, WhatCannotBeRemovedIsStillRecognized) {
  const TemporaryFolder folder;
  fs::permissions(folder.path(), fs::perms::all);
  const AsUser user;
  const auto make = [&] {
    AtomicFolder result(folder / "result", Existing::replace);
    fs::create_directory(result.path() / "recording");
    write_text(result.path() / "recording/frames.csv", "x");
    result.commit();
  };
  make();
  fs::permissions(folder / "result/recording", fs::perms::owner_read | fs::perms::owner_exec);
  make();
  EXPECT_THAT(error_of(make), HasSubstr(".result.partial/recording: cannot be removed: Permission denied"));
  fs::permissions(folder / ".result.partial/recording", fs::perms::owner_all);
  make();
  EXPECT_THAT(names(folder.path()), testing::ElementsAre("result"));
}

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
    EXPECT_THAT(error_of([&] { make("again"); }),
                testing::AllOf(HasSubstr(words), HasSubstr("move it away")));
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
