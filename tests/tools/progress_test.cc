// What the jobs of a command share. Progress lines: the time left does not grow on a steady job, the line
// fits the terminal, and without a terminal a line appears at intervals.
#include "tools/cli/jobs/progress.h"

#include <gmock/gmock.h>

#include <cstdio>
#include <memory>
#include <thread>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"
#include "tools/cli/jobs/results.h"

namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;

/// The reported times left, every tenth of a second.
std::vector<double> left_over(double seconds, const std::function<double(double)>& part) {
  cli::RemainingTime remaining;
  std::vector<double> all;
  for (double t = 0; t < seconds; t += 0.1)
    if (const auto left = remaining.at(part(t), t)) all.push_back(*left);
  return all;
}

void expect_never_growing(const std::vector<double>& left) {
  ASSERT_FALSE(left.empty());
  EXPECT_TRUE(std::is_sorted(left.rbegin(), left.rend()));
  EXPECT_LT(left.back(), 0.15 * left.front() + 1);
}

TEST(RemainingTime, DoesNotGrowOnASteadyJobNorBetweenItsStepsNorWhenItsRateFluctuates) {
  expect_never_growing(left_over(60, [](double t) { return t / 60; }));
  expect_never_growing(left_over(100, [](double t) { return std::floor(t / 10) / 10; }));
  expect_never_growing(left_over(60, [](double t) { return t / 60 + 0.005 * std::sin(t); }));
}

// Nine tenths were done by an earlier command: the rate is that of the last tenth.
TEST(RemainingTime, WhatWasDoneBeforeIsNoRate) {
  const auto left = left_over(100, [](double t) { return t < 0.5 ? 0 : 0.9 + 0.001 * t; });
  EXPECT_NEAR(left.front(), 90, 15);
}

TEST(RemainingTime, GrowsWhereAJobBecomesMuchSlower) {
  const auto left = left_over(200, [](double t) { return t < 20 ? t / 40 : 0.5 + (t - 20) / 400; });
  EXPECT_GT(*std::max_element(left.begin() + 200, left.end()), 25);
}

TEST(Progress, TextNamesPartTimeAndWhatIsBeingDone) {
  EXPECT_EQ(cli::progress_text("walk seed 1", 0.424, 5, 7.4, ""), "walk seed 1: 42 %, 7 s left");
  EXPECT_EQ(cli::progress_text("tune", 0.999, 5, {}, "search"), "tune: 99 %; search");
  EXPECT_EQ(cli::progress_text("export", {}, 185, {}, ""), "export: 3 min 05 s");
}

class ShownProgress : public testing::Test {
 protected:
  /// The output of a line in a third of a second.
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

TEST_F(ShownProgress, WithoutATerminalALineAppearsNowAndThen) {
  const std::string text = shown({.first = 0ms, .heartbeat = 100ms});
  EXPECT_THAT(text, testing::StartsWith("gaitslam: walk: 25 %\n"));
  EXPECT_THAT(text, Not(HasSubstr("\033")));
  EXPECT_GE(std::count(text.begin(), text.end(), '\n'), 2);
}

TEST_F(ShownProgress, BriefOrQuietWorkShowsNothing) {
  EXPECT_EQ(shown({.redraws = true}), "");
  EXPECT_EQ(shown({.redraws = true, .silent = true, .first = 0ms}), "");
}

TEST(Progress, NeverRunsBackwards) {
  const sim::files::TemporaryFolder folder;
  {
    cli::ProgressLine line("walk", {.file = folder / "part"});
    for (const double part : {0.5, 0.2}) line.show(part);
    std::this_thread::sleep_for(330ms);
  }
  EXPECT_DOUBLE_EQ(cli::part_in(folder / "part"), 0.5);
}

TEST_F(ShownProgress, ATerminalHasOneLineThatIsRemovedAtTheEnd) {
  const std::string text = shown({.redraws = true, .first = 0ms});
  EXPECT_THAT(text, HasSubstr("\r\033[Kwalk: 25 %"));
  EXPECT_THAT(text, testing::EndsWith("\r\033[K"));
  EXPECT_THAT(text, Not(HasSubstr("\n")));
}

TEST_F(ShownProgress, WorkThatDoesNotTellHowFarItIsShowsItsTime) {
  EXPECT_THAT(shown({.redraws = true, .first = 0ms}, {}), HasSubstr("walk: 0 s"));
}

TEST_F(ShownProgress, OfTwoLinesTheFirstIsShown) {
  const cli::ProgressLine outer("outer", {.silent = true});
  EXPECT_EQ(shown({.redraws = true, .first = 0ms}), "");
}

TEST_F(ShownProgress, AProcessTellsItsParentAndShowsNothing) {
  EXPECT_EQ(shown({.redraws = true, .file = folder_ / "part", .first = 0ms}), "");
  EXPECT_DOUBLE_EQ(cli::part_in(folder_ / "part"), 0.25);
  EXPECT_EQ(cli::part_in(folder_ / "none"), 0);
}

/// Results of earlier commands, moved out of the way.
class Stale : public testing::Test {
 protected:
  void make(const std::string& name) const {
    fs::create_directory(folder_ / name);
    sim::files::write_text(folder_ / name / "score.json", "{}");
  }
  const sim::files::TemporaryFolder folder_;
};

TEST_F(Stale, OnlyNamesAsTheProgramWritesThemAreResults) {
  for (const char* name : {"seed-1", "seed-2", "seed-10", "seed-07", "seed-+3", "seed-x", "seed-"})
    make(name);
  EXPECT_THAT(cli::results_of_other_seeds(folder_.path(), {1}), testing::ElementsAre("seed-2", "seed-10"));
}

TEST_F(Stale, WhatCannotBeMovedIsNamedAndTheOthersAreMoved) {
  make("seed-1");
  EXPECT_THAT(
      [&] {
        cli::set_aside(folder_.path(), {"seed-7", "seed-1"});
      },
      testing::ThrowsMessage<sim::files::FileError>(
          testing::AllOf(HasSubstr("earlier-1: cannot be moved there: seed-7: No such file or directory"),
                         Not(HasSubstr("seed-1:")))));
  EXPECT_TRUE(fs::exists(folder_ / "earlier-1/seed-1/score.json"));
  EXPECT_THROW(cli::set_aside(folder_.path(), {"seed-7"}), sim::files::FileError);
  EXPECT_FALSE(fs::exists(folder_ / "earlier-2")) << "no empty folder stays";
}

}  // namespace
