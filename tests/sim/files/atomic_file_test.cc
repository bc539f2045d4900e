#include "sim/files/atomic_file.h"

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

TEST(AtomicFile, AFileThatCannotBeWrittenIsReportedAndLeavesNothing) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { write_atomically(folder / "none" / "a.json", "x"); }),
              testing::AllOf(HasSubstr("none"), HasSubstr("No such file or directory")));
  fs::create_directory(folder / "taken");
  EXPECT_THAT(error_of([&] { write_atomically(folder / "taken", "x"); }),
              HasSubstr("taken: cannot be written"));
  EXPECT_THAT(names(folder.path()), testing::ElementsAre("taken"));
}

TEST(AtomicFile, ReplacesOnlyRegularFiles) {
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

TEST(AtomicFolder, AppearsOnlyOnCommit) {
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
  EXPECT_THAT(error_of([&] { result.commit(); }), HasSubstr("result: already exists"));
  EXPECT_EQ(read_text(folder / "result/other"), "of another run");
}

// Runs `work` in a child process that is killed before or after one of its system calls (two stops per call,
// counted from 0). Returns false if it had ended by then.
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

TEST(AtomicFile, WhenKilledAtAnySystemCallIsTheOldOrTheNewFile) {
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

// First without a folder, then with that of an earlier run: the folder is never incomplete or lost.
TEST(AtomicFolder, WhenKilledAtAnySystemCallIsCompleteOrUnchanged) {
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
      EXPECT_TRUE(has_marker(folder / "result")) << "stop " << stop;
      for (const char* name : {"b", "c"})
        EXPECT_EQ(read_text(folder / "result" / name), of) << "stop " << stop;
      ++(of == "new" ? after : before);
      remove_leftovers(folder.path());
      if (replaces && of == "new") {
        EXPECT_EQ(read_text(folder / "earlier-1/result/c"), "old") << "stop " << stop;
      }
    }
    EXPECT_GT(before, 10);
    EXPECT_GT(after, 1);
    killed_at(before - 1, [&] { make("new"); });
    EXPECT_THAT(names(folder.path()), testing::Contains(".result.partial"));
    make("last");
    EXPECT_THAT(names(folder.path()), testing::Not(testing::Contains(".result.partial")));
  }
}

// What a process leaves behind when it is killed just before its folder gets its name.
TEST(AtomicFolder, ACompleteLeftoverGetsItsNameOrIsSetAside) {
  const TemporaryFolder folder;
  for (const char* at : {"result", "earlier-1/result"}) {
    { AtomicFolder(folder / "x").commit(); }
    fs::rename(folder / "x", folder / ".result.partial");
    remove_leftovers(folder.path());
    EXPECT_TRUE(has_marker(folder / at)) << at;
  }
}

TEST(AtomicFolder, ASecondProcessIsRejectedAndTheFirstIsLeftAlone) {
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

class Replaced : public testing::Test {
 protected:
  // Makes a folder as the program does.
  void make(const std::string& text = "made") const {
    AtomicFolder result(folder_ / "result/", Existing::replace);  // a trailing slash means the same folder
    write_text(result.path() / "score.json", text);
    result.commit();
  }
  void write(const std::string& name, const std::string& text = "mine") const {
    fs::create_directories((folder_ / name).parent_path());
    write_text(folder_ / name, text);
  }
  std::string text(const std::string& name) const { return read_text(folder_ / name); }
  const TemporaryFolder folder_;
};

TEST_F(Replaced, AFolderMovesAsideWithWhatTheUserAdded) {
  make();
  EXPECT_THAT(error_of([&] { AtomicFolder rejected(folder_ / "result"); }), HasSubstr("already exists"));
  write("result/notes.txt");
  write("result/score.json", "edited");
  make("again");
  make("thrice");
  EXPECT_EQ(text("result/score.json"), "thrice");
  EXPECT_EQ(text("earlier-1/result/score.json"), "edited");
  EXPECT_EQ(text("earlier-1/result/notes.txt"), "mine");
  EXPECT_EQ(text("earlier-2/result/score.json"), "again");
  AtomicFolder result(folder_ / "result", Existing::replace);
  fs::remove_all(folder_ / "result");
  write("result/letter.txt");  // appears meanwhile
  result.commit();
  EXPECT_EQ(text("earlier-3/result/letter.txt"), "mine");
}

TEST_F(Replaced, WhatTheProgramDidNotMakeIsRejected) {
  write("precious/letter.txt");
  write("marker", "# Made by gaitslam");
  const auto link = [&](const char* to, const char* name) {
    fs::create_symlink(folder_ / to, folder_ / name);
  };
  for (const auto& [made, why] : std::vector<std::pair<std::function<void()>, std::string>>{
           {[&] { write("result/letter.txt"); }, "result: was not created by gaitslam"},
           {[&] { write("result/.gaitslam", "score.json\n"); }, "result: was not created by gaitslam"},
           {[&] { fs::create_directory(folder_ / "result"), link("marker", "result/.gaitslam"); },
            "result: was not created by gaitslam"},
           {[&] { link("precious", "result"); }, "result: is a symbolic link"},
           {[&] { write("result"); }, "result: is a file"},
           {[&] { write(".result.partial/letter.txt"); }, ".result.partial: was not created by gaitslam"}}) {
    made();
    EXPECT_THAT(error_of([&] { make(); }), HasSubstr(why));
    EXPECT_FALSE(fs::exists(folder_ / "result/score.json"));
    fs::remove_all(folder_ / "result");
  }
  EXPECT_EQ(text("precious/letter.txt"), "mine");
  fs::remove_all(folder_ / ".result.partial");
  fs::create_directory(folder_ / "result");
  make();
  EXPECT_TRUE(has_marker(folder_ / "result")) << "an empty folder is replaced";
}

TEST_F(Replaced, OutputsAreClaimedUnlessTheUserHasThemAndMoveAsideTogether) {
  const fs::path root = folder_ / "root";
  write("root/summary.json");
  EXPECT_THAT(
      error_of([&] {
        claim_outputs(root, {"index.html", "summary.json"});
      }),
      HasSubstr("root/summary.json: was not created by gaitslam, which would replace it: move it away"));
  EXPECT_FALSE(has_marker(root));
  claim_outputs(root, {"index.html"});
  claim_outputs(root, {"summary.json"});
  write_output(root / "index.html", "made");
  write_output(root / "index.html", "made");
  EXPECT_FALSE(fs::exists(root / "earlier-1")) << "the same content";
  write_output(root / "summary.json", "made");
  EXPECT_EQ(text("root/earlier-1/summary.json"), "mine");
  EXPECT_EQ(set_aside(root, {"index.html", "summary.json", "none"}), root / "earlier-2");
  EXPECT_EQ(text("root/earlier-2/index.html"), "made");
  EXPECT_EQ(set_aside(root, {"index.html", "none"}), std::nullopt);
}

}  // namespace
}  // namespace sim::files
