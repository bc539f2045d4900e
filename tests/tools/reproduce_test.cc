// The paper's experiments by one command, with short walks.
#include <gmock/gmock.h>

#include <algorithm>

#include "tests/sim/result/result_folder.h"
#include "tests/tools/command_line.h"

namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using tests::differences;
using tests::Ran;

constexpr const char* kWalk =
    "walk: {commands: [{stand: {duration_s: 0.3}}, {straight: {forward_m: 0.15}}]}\n";
constexpr const char* kStand = "walk: {commands: [{stand: {duration_s: 0.2}}]}\n";
class ReproduceTest : public tests::CommandLineWithCache {
 protected:
  ReproduceTest() { write_experiments(kWalk); }
  Ran reproduce(const std::string& arguments = "--out out") const {
    return gaitslam("reproduce --scenarios s --seeds 3 --jobs 2 " + arguments);
  }
  auto made(const std::string& experiment) const {
    return std::filesystem::last_write_time(folder_ / "out" / experiment / "seed-3/score.json");
  }
};
using LongReproduceTest = ReproduceTest;

TEST_F(LongReproduceTest, RunsAllExperimentsOnceAndGoesOnWhereItWasStopped) {
  const Ran first = reproduce();
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_EQ(first.complaints(), "") << "no progress line without a terminal";
  EXPECT_THAT(first.out, testing::AllOf(HasSubstr("page in out/index.html"), Not(HasSubstr("not run"))));
  const std::string page = text_of("out/index.html");
  for (const char* part : {"Figure 1", "Figure 4", "Figure 6", "Figure 7", "Figure 8", "<ellipse"})
    EXPECT_THAT(page, HasSubstr(part));

  const auto walked = made("tangent_circle"), replayed = made("vision_only");
  std::filesystem::remove_all(folder_ / "out/hall_paper/seed-3");
  write("s/vision_only.yaml", std::string(kWalk) + "camera: {}\nslam: {gyro: {enabled: false}}\n");
  ASSERT_EQ(reproduce().exit_code, 0);
  EXPECT_EQ(made("tangent_circle"), walked) << "it was complete";
  EXPECT_NE(made("vision_only"), replayed) << "its scenario is another";
  EXPECT_THAT(text_of("out/hall_paper/seed-3/depths.csv"), HasSubstr("probability"));
}

TEST_F(ReproduceTest, FromTheCacheItGivesTheSameAndWalksEachWalkOnce) {
  write_experiments(kStand);
  ASSERT_EQ(reproduce().exit_code, 0);
  const Ran cached = reproduce("--cached --out cached");
  ASSERT_EQ(cached.exit_code, 0) << cached.out << cached.err;
  EXPECT_THAT(differences(folder_ / "out", folder_ / "cached", "index.html"), IsEmpty());
  const std::string recordings = ok("cache list");
  EXPECT_EQ(std::count(recordings.begin(), recordings.end(), '\n'), 3) << "with camera, without, and the sum";

  const auto walked = made("tangent_circle");
  std::filesystem::copy(std::string(GAITSLAM_SOURCE_DIR) + "/models", folder_ / "m");
  shell("for f in m/*.xml; do echo '<!-- other -->' >> $f; done");
  ASSERT_EQ(reproduce("--out out --models m").exit_code, 0);
  EXPECT_NE(made("tangent_circle"), walked) << "walks in other models are made again";
}

TEST_F(ReproduceTest, WhatIsWrongIsSaidBeforeAnythingIsRun) {
  std::filesystem::remove(folder_ / "s/hall.yaml");
  expect_refused({{"reproduce --out out --seeds 3..1 --scenarios s", "3..1"},
                  {"reproduce --out out --scenarios s", "s/hall.yaml: cannot be read"}});
}

}  // namespace
