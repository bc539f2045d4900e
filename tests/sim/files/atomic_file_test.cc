#include "sim/files/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <stdexcept>

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

}  // namespace
}  // namespace sim::files
