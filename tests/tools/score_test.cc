// Trajectories that cannot be scored are errors with a reason and, if one is at fault, the line.
#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "tests/tools/command_line.h"

namespace tests {
namespace {

/// A line of a TUM file.
std::string tum(double t, double x, double y) { return fmt::format("{:.9f} {} {} 1 0 0 0 1\n", t, x, y); }

/// The rows of ten seconds of a curve at 30 Hz: row(i, t, x = t, y = sin t).
using Row = std::function<std::string(int i, double t, double y)>;
std::string curve(const Row& row, int count = 300) {
  std::string text;
  for (int i = 0; i < count; ++i) text += row(i, i / 30.0, std::sin(i / 30.0));
  return text;
}

class Score : public CommandLine {
 protected:
  Score() {
    write_curve("truth.tum", [](int, double t, double y) { return tum(t, t, y); });
  }
  void write_curve(const std::string& name, const Row& row) const { write(name, curve(row)); }
  static std::string kitti(int, double t, double y) {
    return fmt::format("1 0 0 {} 0 1 0 {} 0 0 1 1\n", t, y);
  }
};

TEST_F(Score, FrameNumbersAreNoTimes) {
  write_curve("frames.tum",
              [](int i, double t, double y) { return fmt::format("{} {} {} 1 0 0 0 1\n", i, t, y); });
  write_curve("poses.csv",
              [](int i, double t, double y) { return fmt::format("{},{},{},1,1,0,0,0\n", i, t, y); });
  write_curve("poses.txt", kitti);
  write("once_a_second.tum",
        curve([](int i, double, double) { return fmt::format("{} {} {} 1 0 0 0 1\n", i, i, std::sin(i)); },
              10));
  expect_refused(
      {{"score truth.tum frames.tum",
        "frames.tum: its stamps are whole numbers up to 299, as frame numbers are, those of truth.tum are "
        "times over 9.967 s"},
       {"score frames.tum truth.tum", "frames.tum: its stamps are whole numbers up to 299"},
       {"score truth.tum poses.txt",
        "poses.txt: its stamps are frame numbers, those of truth.tum are times in seconds; times.txt"},
       {"score truth.tum poses.csv", "poses.csv: its stamps are whole numbers up to 299"}});
  for (const char* files : {"truth.tum once_a_second.tum", "frames.tum frames.tum"})
    ok(std::string("score ") + files);
}

TEST_F(Score, TheUnitOfStampsIsRecognizedOrRejected) {
  write_curve("us.csv",
              [](int, double t, double y) { return fmt::format("{:.0f},{},{},1,1,0,0,0\n", 1e6 * t, t, y); });
  write_curve("ms.tum", [](int, double t, double y) { return tum(1000 * t, t, y); });
  write_curve("minutes.tum", [](int, double t, double y) { return tum(t / 60, t, y); });
  for (const auto& [file, unit] : {std::pair("us.csv", "microseconds"), {"ms.tum", "milliseconds"}})
    EXPECT_THAT(ok(std::string("score truth.tum ") + file),
                AllOf(HasSubstr(fmt::format("from 0.000 to 9.967 s, stamps in {}", unit)),
                      HasSubstr("\nmatched   300")));
  for (const char* options : {"", " --interpolate"})
    expect_refused({{fmt::format("score truth.tum minutes.tum{}", options),
                     "minutes.tum: its 300 poses last 0.166 s, the 300 of truth.tum last 9.967 s: their "
                     "stamps are not in the same unit"},
                    {fmt::format("score minutes.tum truth.tum{}", options), "are not in the same unit"}});
}

TEST_F(Score, NumbersThatNoOptionCanHaveAreRefused) {
  const std::string score = "score truth.tum truth.tum ";
  for (const char* offset : {"inf", "nan", "1e10", "-1e300"})
    expect_refused(score + "--align none --t-offset " + offset, "--t-offset ");
  expect_refused(score + "--t-max-diff nan", "--t-max-diff");
  for (const char* tolerance : {"-1", "nan", "inf"})
    expect_refused(score + "-d 1 -u m --all-pairs --delta-tol " + tolerance, "--delta-tol");
  for (const char* delta : {"inf", "nan", "-1", "0"}) expect_refused(score + "-u m -d " + delta, "-d");
  expect_refused(score + "-d 1e300", "-d 1e+300");
}

// Stamps of exports start at 1e9 s, and a program that needs time to initialize has no poses for the first
// seconds.
TEST_F(Score, AnotherClockIsAnsweredWithTheOffsetByWhichMostStampsMeet) {
  write_curve("late.tum", [](int i, double t, double) { return i < 141 ? "" : tum(1e9 + t, t, 0); });
  write_curve("shifted.tum", [](int, double t, double) { return tum(77.25 + t, t, 0); });
  write_curve("later.tum", [](int i, double t, double) { return tum((298 + i) / 30.0, t, 0); });
  expect_refused(
      {{"score truth.tum late.tum",
        "the truth is from 0.000 to 9.967 s, the estimate from 1000000004.700 to 1000000009.967 s; with "
        "--t-offset -1000000000 159 of its poses have a true one"},
       {"score truth.tum shifted.tum", "with --t-offset -77.25 300 of its poses have a true one"},
       {"score truth.tum later.tum",
        "2 of 300 estimated poses have a true one, over 0.033 s: the truth is from 0.000 to 9.967 s"}});
  ok("score truth.tum late.tum --t-offset -1000000000");
}

TEST_F(Score, PosesThatSayNothingAreRefused) {
  write_curve("still.tum", [](int, double t, double) { return tum(t, 2, 1); });
  write_curve("all.txt", kitti);
  write("half.txt", curve([](int i, double t, double y) { return kitti(i, 2 * t, y); }, 150));
  write_curve("late.txt", [](int i, double t, double y) { return i < 10 ? "" : kitti(i, 2 * t, y); });
  const std::string still = "still.tum: all 300 matched poses coincide",
                    unpaired = "all without times: they cannot be paired by their row";
  expect_refused({{"score truth.tum still.tum", still},
                  {"score still.tum truth.tum", still},
                  {"score truth.tum still.tum --align sim3", "coincide"},
                  {"score all.txt half.txt", unpaired},
                  {"score all.txt late.txt --align none", unpaired},
                  {"score half.txt all.txt --align se3", unpaired}});
  ok("score truth.tum still.tum -r angle_deg");  // a camera may turn on the spot
  write("short.tum", tum(0, 0, 0) + tum(1 / 30., 0.1, 0) + tum(2 / 30., 0.2, 0));
  ok("score truth.tum short.tum");
}

TEST_F(Score, InterpolationCrossesNoGapLongerThanStated) {
  write_curve("gap.tum", [](int i, double t, double y) { return i < 100 || i > 200 ? tum(t, t, y) : ""; });
  const std::string score = "score gap.tum truth.tum --align none ";
  EXPECT_THAT(ok(score + "--interpolate"),
              HasSubstr("matched   199 of 300 poses (truth interpolated at the estimate's stamps, across "
                        "at most 0.1 s)"));
  EXPECT_THAT(ok(score + "--interpolate --max-gap 5"), HasSubstr("matched   300 of 300 poses"));
  expect_refused(score + "--max-gap 5", "--interpolate");
}

TEST_F(Score, TheReportStatesHowMuchOfTheTruthIsCovered) {
  write_curve("straight.tum", [](int, double t, double) { return tum(t, t, 0); });
  write_curve("two.tum", [](int i, double t, double) { return i < 60 || i >= 240 ? tum(t, t, 0) : ""; });
  write_curve("first.tum", [](int i, double t, double) { return i < 60 ? tum(t, t, 0) : ""; });
  for (const auto& [estimate, covered] :
       {std::pair("two", "120 of 300 true poses, 40.0 % of the time; 9.967 m"),
        {"first", "60 of 300 true poses, 20.0 % of the time; 1.967 m"}})
    EXPECT_THAT(ok(fmt::format("score straight.tum {}.tum", estimate)),
                HasSubstr(fmt::format("covered   {} walked", covered)));
}

TEST_F(Score, ACovarianceThatIsTooSmallGivesNoNumber) {
  write_curve("sure.tum", [](int, double t, double) {
    return fmt::format("{:.9f} {} 0 1 0 0 0 1 1 0 0 1 0 1 1e-307 0 0 1e-307 0 1e-307\n", t, 2 * t);
  });
  const std::string scored = ok("score truth.tum sure.tum --json");
  EXPECT_EQ(scored.find("inf"), scored.npos);
  EXPECT_THAT(scored, testing::AnyOf(HasSubstr("a value is not finite"), HasSubstr("not positive definite")));
}

}  // namespace
}  // namespace tests
