// Trajectories that cannot be scored are errors with a reason and, if one is at fault, the line.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "tests/tools/command_line.h"

namespace {

using testing::HasSubstr;
using tests::Ran;

class Score : public tests::CommandLine {
 protected:
  Score() { write("truth.tum", curve(30)); }

  /// A line of a TUM file.
  static std::string line(const std::string& stamp, double x, double y) {
    return fmt::format("{} {} {} 1 0 0 0 1\n", stamp, x, y);
  }
  /// Ten seconds of a curve with stamps in units of `unit_s`.
  static std::string curve(double rate_hz, bool counts_frames = false, double unit_s = 1) {
    std::string text;
    for (int i = 0; i < 10 * rate_hz; ++i) {
      const double t = i / rate_hz;
      text += line(counts_frames ? std::to_string(i) : fmt::format("{:.9f}", t / unit_s), t, std::sin(t));
    }
    return text;
  }
  std::string all_in_one_point() const {
    std::string text;
    for (int i = 0; i < 300; ++i) text += line(fmt::format("{:.9f}", i / 30.0), 2, 1);
    return text;
  }
};

TEST_F(Score, FrameNumbersAreNoTimes) {
  write("frames.tum", curve(30, true));
  expect_refused(
      "score truth.tum frames.tum",
      "frames.tum: its stamps are whole numbers up to 299, as frame numbers are, those of truth.tum are "
      "times over 9.967 s");
  expect_refused("score frames.tum truth.tum", "frames.tum: its stamps are whole numbers up to 299");
  expect_refused("score truth.tum frames.tum --align se3 --json", "frames.tum: its stamps are whole numbers");
  write("once_a_second.tum", curve(1));
  EXPECT_EQ(gaitslam("score truth.tum once_a_second.tum").exit_code, 0) << "these are times";
  EXPECT_EQ(gaitslam("score frames.tum frames.tum").exit_code, 0);

  std::string kitti, csv;
  for (int i = 0; i < 300; ++i) {
    kitti += fmt::format("1 0 0 {} 0 1 0 {} 0 0 1 1\n", i / 30.0, std::sin(i / 30.0));
    csv += fmt::format("{},{},{},1,1,0,0,0\n", i, i / 30.0, std::sin(i / 30.0));
  }
  write("poses.txt", kitti);
  write("poses.csv", csv);
  expect_refused(
      "score truth.tum poses.txt",
      "poses.txt: its stamps are frame numbers, those of truth.tum are times in seconds; times.txt");
  expect_refused("score truth.tum poses.csv", "poses.csv: its stamps are frame numbers");
  EXPECT_EQ(gaitslam("score poses.txt poses.csv").exit_code, 0) << "both count frames";
}

TEST_F(Score, TheUnitOfStampsIsRecognizedOrRejected) {
  std::string microseconds;
  for (int i = 0; i < 300; ++i)
    microseconds += fmt::format("{:.0f},{},{},1,1,0,0,0\n", 1e6 * i / 30, i / 30.0, std::sin(i / 30.0));
  write("us.csv", microseconds);
  write("ms.tum", curve(30, false, 0.001));
  write("minutes.tum", curve(30, false, 60));
  for (const auto& [file, unit] : {std::pair("us.csv", "microseconds"), {"ms.tum", "milliseconds"}}) {
    const Ran scored = gaitslam(std::string("score truth.tum ") + file);
    EXPECT_THAT(scored.out,
                HasSubstr(fmt::format("from 0.000 to 9.967 s, stamps in {}\nmatched   300", unit)));
  }
  for (const char* options : {"", " --interpolate"}) {
    expect_refused(
        fmt::format("score truth.tum minutes.tum{}", options),
        "minutes.tum: its 300 poses last 0.166 s, the 300 of truth.tum last 9.967 s: their stamps are "
        "not in the same unit");
    expect_refused(fmt::format("score minutes.tum truth.tum{}", options), "are not in the same unit");
  }
}

// The same poses in files that name their columns or print their times otherwise.
TEST_F(Score, FilesAreReadByWhatTheyState) {
  std::string named = "timestamp,tx,ty,tz,qx,qy,qz,qw\n", first = "# timestamp tx ty tz qw qx qy qz\n",
              floats, turned;
  for (int i = 0; i < 300; ++i) {
    const double t = i / 30.0, a = 0.02 * i, c = std::cos(a), s = std::sin(a);
    turned += fmt::format("{:.9f} {} {} 1 0 0 {} {}\n", t, t, std::sin(t), s, c);
    named += fmt::format("{:.9f},{},{},1,0,0,{},{}\n", t, t, std::sin(t), s, c);
    first += fmt::format("{:.9f} {} {} 1 {} 0 0 {}\n", t, t, std::sin(t), c, s);
    floats += fmt::format("{:.18e},{},{},1,{},0,0,{}\n", 1e9 * t + 1.4e18, t, std::sin(t), c, s);
  }
  write("turned.tum", turned);
  write("named.csv", named);
  write("first.txt", first);
  write("floats.csv", floats);
  for (const std::string file : {"named.csv", "first.txt", "floats.csv --t-offset -1400000000"})
    for (const std::string relation : {"trans_part", "angle_deg"}) {
      const Ran ran = gaitslam("score turned.tum " + file + " --align none -r " + relation + " --json");
      EXPECT_EQ(ran.exit_code, 0) << file << ran.err;
      EXPECT_THAT(ran.out, testing::ContainsRegex("\"max\": ([0-9.]+e-|0\\.00000|0[,.\n])"))
          << file << relation;
    }
}

TEST_F(Score, AShortEstimateAndAFewKeyframesAreScored) {
  write("short.tum", line("0.0", 0, 0) + line("0.033333333", 0.1, 0) + line("0.066666667", 0.2, 0));
  write("fast.tum", curve(3000));
  EXPECT_EQ(gaitslam("score truth.tum short.tum").exit_code, 0);
  EXPECT_EQ(gaitslam("score fast.tum truth.tum").exit_code, 0);
}

TEST_F(Score, PosesThatMeetInAnInstantSayNothing) {
  std::string later;
  for (int i = 0; i < 300; ++i) later += line(fmt::format("{:.9f}", (298 + i) / 30.0), i / 30.0, 0);
  write("later.tum", later);
  expect_refused(
      "score truth.tum later.tum",
      "2 of 300 estimated poses have a true one, over 0.033 s: the truth is from 0.000 to 9.967 s");
}

TEST_F(Score, NumbersThatNoOptionCanHaveAreRefused) {
  for (const char* offset : {"inf", "nan", "1e10", "1e300", "-1e300"})
    expect_refused(fmt::format("score truth.tum truth.tum --align none --t-offset {}", offset),
                   "--t-offset ");
  expect_refused("score truth.tum truth.tum --t-max-diff nan", "--t-max-diff");
  for (const char* tolerance : {"-1", "nan", "inf"})
    expect_refused(fmt::format("score truth.tum truth.tum -d 1 -u m --all-pairs --delta-tol {}", tolerance),
                   "--delta-tol");
  for (const char* delta : {"inf", "nan", "-1", "0"})
    expect_refused(fmt::format("score truth.tum truth.tum -u m -d {}", delta), "-d");
  expect_refused("score truth.tum truth.tum -d 1e300", "-d 1e+300");
}

// Stamps of exports start at 1e9 s, and a program that needs time to initialize has no poses for the first
// seconds.
TEST_F(Score, AnotherClockIsAnsweredWithTheOffsetByWhichMostStampsMeet) {
  std::string late, shifted;
  for (int i = 141; i < 300; ++i) late += line(fmt::format("{:.6f}", 1e9 + i / 30.0), i / 30.0, 0);
  write("late.tum", late);
  expect_refused("score truth.tum late.tum",
                 "the truth is from 0.000 to 9.967 s, the estimate from 1000000004.700 to 1000000009.967 s; "
                 "with --t-offset "
                 "-1000000000 159 of its poses have a true one");
  EXPECT_EQ(gaitslam("score truth.tum late.tum --t-offset -1000000000").exit_code, 0);
  for (int i = 0; i < 300; ++i) shifted += line(fmt::format("{:.9f}", 77.25 + i / 30.0), i / 30.0, 0);
  write("shifted.tum", shifted);
  expect_refused("score truth.tum shifted.tum", "with --t-offset -77.25 300 of its poses have a true one");
}

TEST_F(Score, CoordinatesBeyondReasonAreNamedWithTheirLine) {
  write("far.tum", line("0.0", 0, 0) + "0.033333333 1 1e308 1 0 0 0 1\n");
  expect_refused("score truth.tum far.tum", "far.tum:2:15: a position of more than 1e9 m");
  write("far.csv", "0,1,2,3,1,0,0,0\n33333333,-1e200,2,3,1,0,0,0\n");
  expect_refused("score truth.tum far.csv", "far.csv:2:10: a position of more than 1e9 m");
  write("far.txt", "1 0 0 0 0 1 0 0 0 0 1 1e12\n");
  expect_refused("score truth.tum far.txt", "far.txt:1:23: a position of more than 1e9 m");
}

TEST_F(Score, PosesThatAreAllInOnePointSayNothing) {
  write("still.tum", all_in_one_point());
  expect_refused("score truth.tum still.tum", "still.tum: all 300 matched poses coincide");
  expect_refused("score still.tum truth.tum", "still.tum: all 300 matched poses coincide");
  expect_refused("score truth.tum still.tum --align sim3", "coincide");
  EXPECT_EQ(gaitslam("score truth.tum still.tum -r angle_deg").exit_code, 0)
      << "a camera may turn on the spot";
}

TEST_F(Score, RowsWithoutTimesArePairedOnlyIfTheyAreAsMany) {
  std::string all, half;
  for (int i = 0; i < 200; ++i) {
    const std::string row = fmt::format("1 0 0 {} 0 1 0 {} 0 0 1 1\n", i / 20.0, std::sin(i / 20.0));
    all += row;
    if (i % 2 == 0) half += row;
  }
  write("all.txt", all);
  write("half.txt", half);
  EXPECT_EQ(gaitslam("score all.txt all.txt").exit_code, 0);
  for (const char* files : {"all.txt half.txt", "half.txt all.txt", "all.txt half.txt --align se3"})
    expect_refused(fmt::format("score {}", files), "all without times: they cannot be paired by their row");
}

TEST_F(Score, InterpolationCrossesNoGapLongerThanStated) {
  std::string gap;
  for (int i = 0; i < 300; ++i)
    if (i < 100 || i > 200) gap += line(fmt::format("{:.9f}", i / 30.0), i / 30.0, std::sin(i / 30.0));
  write("gap.tum", gap);
  const auto rows = [&](const std::string& options) {
    return gaitslam("score gap.tum truth.tum --align none --interpolate " + options).out;
  };
  EXPECT_THAT(rows(""),
              HasSubstr("matched   199 of 300 poses (truth interpolated at the estimate's stamps, across "
                        "at most 0.1 s)"));
  EXPECT_THAT(rows("--max-gap 5"), HasSubstr("matched   300 of 300 poses"));
  expect_refused("score gap.tum truth.tum --max-gap 5", "--interpolate");
}

TEST_F(Score, TheReportStatesHowMuchOfTheTruthIsCovered) {
  std::string first, two;
  for (int i = 0; i < 300; ++i) {
    const std::string row = line(fmt::format("{:.9f}", i / 30.0), i / 30.0, 0);
    if (i < 60) first += row;
    if (i < 60 || i >= 240) two += row;
  }
  write("first.tum", first);
  write("two.tum", two);
  write("straight.tum", [] {
    std::string text;
    for (int i = 0; i < 300; ++i) text += line(fmt::format("{:.9f}", i / 30.0), i / 30.0, 0);
    return text;
  }());
  EXPECT_THAT(gaitslam("score straight.tum first.tum").out,
              HasSubstr("covered   60 of 300 true poses, 20.0 % of the time; 1.967 m walked"));
  EXPECT_THAT(gaitslam("score straight.tum two.tum").out,
              HasSubstr("covered   120 of 300 true poses, 40.0 % of the time; 9.967 m walked"));
}

TEST_F(Score, ACovarianceThatIsTooSmallGivesNoNumber) {
  std::string text;
  for (int i = 0; i < 300; ++i)
    text += fmt::format("{:.9f} {} 0 1 0 0 0 1 1 0 0 1 0 1 1e-307 0 0 1e-307 0 1e-307\n", i / 30.0, i / 15.0);
  write("sure.tum", text);
  const Ran ran = gaitslam("score truth.tum sure.tum --json");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(ran.out.find("inf"), ran.out.npos);
  EXPECT_THAT(ran.out,
              testing::AnyOf(HasSubstr("a value is not finite"), HasSubstr("not positive definite")));
}

}  // namespace
