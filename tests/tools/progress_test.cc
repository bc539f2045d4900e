// Progress lines: the remaining time does not grow on a steady job, the line fits the terminal, and without a
// terminal a line appears at intervals. Also the temporary folders of processes that start at the same time.
#include "tools/cli/jobs/progress.h"

#include <sys/wait.h>

#include "tests/sim/files/temporary_folder.h"
#include "tools/cli/jobs/jobs.h"

namespace {

using namespace std::chrono_literals;
using testing::AllOf, tests::Has, tests::Lacks;

/// The reported remaining times, every tenth of a second.
std::vector<double> left_over(double seconds, const std::function<double(double)>& part) {
  cli::RemainingTime remaining;
  std::vector<double> all;
  for (double t = 0; t < seconds; t += 0.1)
    if (const auto left = remaining.at(part(t), t)) all.push_back(*left);
  return all;
}

TEST(RemainingTime, DoesNotGrowOnASteadyJobNorBetweenItsStepsNorWhenItsRateFluctuates) {
  for (const auto& left : {left_over(60, [](double t) { return t / 60; }),
                           left_over(100, [](double t) { return std::floor(t / 10) / 10; }),
                           left_over(60, [](double t) { return t / 60 + 0.005 * std::sin(t); })}) {
    ASSERT_FALSE(left.empty());
    EXPECT_TRUE(std::is_sorted(left.rbegin(), left.rend()));
    EXPECT_LT(left.back(), 0.15 * left.front() + 1);
  }
}

TEST(RemainingTime, FollowsTheCurrentRateOfThisCommand) {
  const auto resumed = left_over(100, [](double t) { return t < 0.5 ? 0 : 0.9 + 0.001 * t; });
  EXPECT_NEAR(resumed.front(), 90, 15) << "nine tenths were done by an earlier command";
}

class Progress : public testing::Test {
 protected:
  /// The output of a progress line within a third of a second.
  std::string shown(cli::ProgressPlace place, std::optional<double> part = 0.25) const {
    const auto file = folder_ / "shown";
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "w"), std::fclose);
    place.stream = stream.get();
    {
      cli::ProgressLine line("walk", place);
      if (part) line.show(*part);
      std::this_thread::sleep_for(330ms);
    }
    std::fflush(stream.get());
    return sim::files::read_text(file);
  }
  const sim::files::TemporaryFolder folder_;
};

TEST_F(Progress, IsOneLineOnATerminalAndOtherwiseALineNowAndThen) {
  EXPECT_EQ(cli::progress_text("walk seed 1", 0.424, 5, 7.4, ""), "walk seed 1: 42 %, 7 s left");
  EXPECT_EQ(cli::progress_text("tune", 0.999, 5, {}, "search"), "tune: 99 %; search");
  const std::string lines = shown({.first = 0ms, .heartbeat = 100ms});
  EXPECT_THAT(lines, AllOf(testing::StartsWith("gaitslam: walk: 25 %\n"), Lacks("\033")));
  EXPECT_GE(std::ranges::count(lines, '\n'), 2);
  EXPECT_THAT(shown({.redraws = true, .first = 0ms}),
              AllOf(Has("\r\033[Kwalk: 25 %"), testing::EndsWith("\r\033[K"), Lacks("\n")));
}

TEST_F(Progress, IsNotShownForBriefQuietInnerOrChildWork) {
  EXPECT_EQ(shown({.redraws = true}), "");
  EXPECT_EQ(shown({.redraws = true, .silent = true, .first = 0ms}), "");
  EXPECT_EQ(shown({.redraws = true, .file = folder_ / "part", .first = 0ms}), "");
  EXPECT_DOUBLE_EQ(cli::part_in(folder_ / "part"), 0.25) << "the parent is told";
  {
    cli::ProgressLine line("walk", {.file = folder_ / "part"});
    for (const double part : {0.5, 0.2}) line.show(part);
    std::this_thread::sleep_for(330ms);
  }
  EXPECT_DOUBLE_EQ(cli::part_in(folder_ / "part"), 0.5) << "it never runs backward";
  const cli::ProgressLine outer("outer", {.silent = true});
  EXPECT_EQ(shown({.redraws = true, .first = 0ms}), "");
}

TEST(TemporaryFolders, AreNotMistakenForAbandonedWhenProcessesStartTogether) {
  const sim::files::TemporaryFolder all;
  setenv("TMPDIR", all.path().c_str(), 1);
  std::vector<pid_t> children(8);
  for (pid_t& child : children)
    if ((child = fork()) == 0) {
      int failed = 0;
      try {
        for (int i = 0; i < 200; ++i) cli::TemporaryFolder();
      } catch (const std::exception& e) {
        failed = 1, std::cerr << e.what() << '\n';
      }
      _exit(failed);
    }
  for (const pid_t child : children) {
    int status = -1;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }
  unsetenv("TMPDIR");
  EXPECT_TRUE(std::filesystem::is_empty(all.path()));
}

}  // namespace
