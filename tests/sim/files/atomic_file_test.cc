#include "sim/files/atomic_file.h"

#include <signal.h>
#include <sys/ptrace.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#include "tests/sim/files/temporary_folder.h"

namespace sim::files {
namespace {

using testing::HasSubstr;

std::vector<std::string> names(const fs::path& folder) {
  std::vector<std::string> all;
  for (const auto& entry : fs::directory_iterator(folder)) all.push_back(entry.path().filename().string());
  return all;
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
  AtomicFolder result(folder / "parents/too/result/");  // a trailing slash means the same folder
  write_text(result.path() / "score.json", "{}");
  EXPECT_FALSE(fs::exists(folder / "parents/too/result"));
  EXPECT_EQ(result.path().parent_path(), folder / "parents/too") << "on the same file system";
  result.commit();
  EXPECT_EQ(read_text(folder / "parents/too/result/score.json"), "{}");
  EXPECT_TRUE(has_marker(folder / "parents/too/result"));
  EXPECT_THAT(names(folder / "parents/too"), testing::ElementsAre("result"));
}

TEST(AtomicFolder, DoesNotOverwriteWhatAUserMadeMeanwhile) {
  const TemporaryFolder folder;
  AtomicFolder result(folder / "result");
  fs::create_directory(folder / "result");
  write_text(folder / "result/other", "mine");
  EXPECT_THAT(error_of([&] { result.commit(); }), HasSubstr("result: cannot be written: "));
  EXPECT_EQ(read_text(folder / "result/other"), "mine");
}

/// A child process that stops at each system call.
class Traced {
 public:
  explicit Traced(const auto& work) : child_(fork()) {
    if (child_ == 0) {
      ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
      raise(SIGSTOP);
      work();
      _exit(0);
    }
    waitpid(child_, nullptr, 0);
    ptrace(PTRACE_SETOPTIONS, child_, nullptr, PTRACE_O_TRACESYSGOOD);
  }
  ~Traced() {
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }
  /// Continues to the beginning or the end of a system call. Returns the call at its beginning, -1 at its
  /// end, and nothing if the process has ended.
  std::optional<long> next() {
    if (ptrace(PTRACE_SYSCALL, child_, nullptr, nullptr) != 0) throw std::runtime_error("cannot be traced");
    int status = 0;
    waitpid(child_, &status, 0);
    __ptrace_syscall_info info{};
    if (WIFEXITED(status)) return std::nullopt;
    ptrace(PTRACE_GET_SYSCALL_INFO, child_, sizeof info, &info);
    return info.op == PTRACE_SYSCALL_INFO_ENTRY ? static_cast<long>(info.entry.nr) : -1;
  }

 private:
  pid_t child_;
};

/// Runs `work` in a process that is killed before or after one of its system calls (two stops per call,
/// counted from 0). Returns false if it had ended by then.
bool killed_at(int stop, const auto& work) {
  Traced traced(work);
  for (int k = 0; k <= stop; ++k)
    if (!traced.next()) return false;
  return true;
}

/// The system calls of `work` that change or flush files: w(rite), f(sync), s(yncfs), r(ename), u(nlink).
/// Repeated ones appear once.
std::string order_of(const auto& work) {
  const std::map<long, char> letters{
      {SYS_write, 'w'},     {SYS_writev, 'w'}, {SYS_fsync, 'f'},    {SYS_syncfs, 's'}, {SYS_rename, 'r'},
      {SYS_renameat2, 'r'}, {SYS_unlink, 'u'}, {SYS_unlinkat, 'u'}, {SYS_rmdir, 'u'},  {SYS_renameat, 'r'}};
  Traced traced(work);
  std::string order;
  while (const auto call = traced.next())
    if (const auto found = letters.find(*call); found != letters.end() && !order.ends_with(found->second))
      order += found->second;
  return order;
}

// Otherwise, a power failure could leave the name without the content, or neither the old nor the new result.
TEST(Publish, FlushesWhatWasWrittenRenamesItFlushesTheNameAndOnlyThenRemovesTheOldOne) {
  const TemporaryFolder folder;
  const auto write_file = [&] { write_atomically(folder / "a.json", "text"); };
  for (const char* when : {"new", "replaced"}) EXPECT_EQ(order_of(write_file), "wfrf") << when;
  const auto make = [&] {
    AtomicFolder result(folder / "result");
    write_text(result.path() / "a", "text");
    result.commit();
  };
  EXPECT_EQ(order_of(make), "wsrf");
  EXPECT_EQ(order_of(make), "wsrfu");
}

// First without a folder, then with an earlier run's folder, which has its name or is .result.old.
TEST(AtomicFolder, WhenKilledAtAnySystemCallLeavesACompleteResult) {
  for (const bool replaces : {false, true}) {
    const TemporaryFolder folder;
    const auto make = [&](const std::string& text) {
      AtomicFolder result(folder / "result");
      for (const char* name : {"a", "b", "c"}) write_text(result.path() / name, text);
      result.commit();
    };
    std::map<std::string, int> found;
    for (int stop = 0;; ++stop) {
      if (replaces) {
        make("old");
        EXPECT_THAT(names(folder.path()), testing::ElementsAre("result")) << "leftovers at stop " << stop;
      } else {
        for (const std::string& name : names(folder.path())) fs::remove_all(folder / name);
      }
      if (!killed_at(stop, [&] { make("new"); })) break;
      const bool named = fs::exists(folder / "result");
      const fs::path result = folder / (named ? "result" : ".result.old");
      if (!replaces && !named) {
        ++found["none"];
        continue;
      }
      const std::string of = read_text(result / "a");
      EXPECT_TRUE(of == "new" || (replaces && of == "old")) << "stop " << stop << ": " << of;
      EXPECT_THAT(names(result), testing::UnorderedElementsAre("a", "b", "c", kMarker)) << "stop " << stop;
      for (const char* name : {"b", "c"}) EXPECT_EQ(read_text(result / name), of) << "stop " << stop;
      ++found[named ? of : "aside"];
    }
    EXPECT_GT(found[replaces ? "old" : "none"], 10);
    EXPECT_GT(found["new"], 1);
    EXPECT_EQ(found["aside"], replaces ? 2 : 0) << "after one rename and before the next";
  }
}

TEST(AtomicFolder, ASecondProcessIsRejectedAndTheFirstIsLeftAlone) {
  const TemporaryFolder folder;
  AtomicFolder first(folder / "result");
  write_text(first.path() / "a", "x");
  const pid_t second = fork();
  if (second == 0) {
    const std::string error = error_of([&] { AtomicFolder(folder / "result"); });
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
  mark_folder(folder / ".a.partial");
  fs::permissions(folder / ".a.partial" / kMarker, fs::perms::none);
  fs::permissions(folder.path(), fs::perms::all);
  const AsUser user;
  for (const char* name : {".b.partial", ".c.old", "d.old", ".e"}) mark_folder(folder / name);
  remove_leftovers(folder.path());
  EXPECT_THAT(names(folder.path()), testing::UnorderedElementsAre(".a.partial", "d.old", ".e"));
}

TEST(AtomicFolder, ReplacesOnlyEmptyAndMarkedFolders) {
  const TemporaryFolder folder;
  const auto write = [&](const std::string& name) {
    fs::create_directories((folder / name).parent_path());
    write_text(folder / name, "mine");
  };
  const auto link = [&](const char* to, const char* name) { fs::create_symlink(folder / to, folder / name); };
  write("precious/letter.txt");
  write("marker");
  for (const auto& [made, why] : std::vector<std::pair<std::function<void()>, std::string>>{
           {[&] { write("result/letter.txt"); }, "result: was not created by gaitslam: move it away"},
           {[&] { fs::create_directory(folder / "result"), link("marker", "result/.gaitslam"); },
            "result: was not created by gaitslam"},
           {[&] { link("precious", "result"); }, "result: is a symbolic link"},
           {[&] { write("result"); }, "result: is a file"}}) {
    made();
    EXPECT_THAT(error_of([&] { AtomicFolder result(folder / "result"); }), HasSubstr(why));
    EXPECT_THAT(error_of([&] { mark_folder(folder / "result"); }), HasSubstr(why));
    fs::remove_all(folder / "result");
  }
  write(".result.partial/letter.txt");
  EXPECT_THAT(error_of([&] { AtomicFolder result(folder / "result"); }),
              HasSubstr(".result.partial: was not created by gaitslam"));
  EXPECT_EQ(read_text(folder / "precious/letter.txt"), "mine");
  EXPECT_EQ(read_text(folder / ".result.partial/letter.txt"), "mine");
  fs::create_directory(folder / "empty");
  AtomicFolder(folder / "empty").commit();
  EXPECT_TRUE(has_marker(folder / "empty"));
}

}  // namespace
}  // namespace sim::files
