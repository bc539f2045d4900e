// A run exported in the format of another program and replayed as a third-party recording.
#include "tests/tools/command_line.h"

namespace tests {
namespace {

// One run and one export serve all tests of the process. Each test changes its own copy of the export.
class Exchange : public CommandLine {
 protected:
  Exchange() {
    if (!fs::exists(run_)) {
      write("walk.yaml", scenario_of("{stand: {duration_s: 0.3}}, {straight: {forward_m: 0.3, left_m: 0}}",
                                     "rate_hz: 10"));
      ok("run walk.yaml --out '" + run_.string() + "'");
      ok("export '" + run_.string() + "/seed-1' --format euroc --out '" + run_.string() + "/e'");
    }
    fs::create_directory_symlink(run_, folder_ / "r");
    fs::copy(run_ / "e", folder_ / "e", fs::copy_options::recursive);
  }
  static void TearDownTestSuite() { fs::remove_all(run_); }

  double value(const std::string& folder, const std::string& name) const {
    return metric(folder_ / folder, name);
  }
  std::string reason(const std::string& folder, const std::string& name) const {
    return json_in(folder + "/score.json")["metrics"][name]["reason"];
  }

  static inline const fs::path run_ =
      fs::temp_directory_path() / ("gaitslam exchange " + std::to_string(getpid()));
};

// The export has readings of 5 ms, while the run splits some at frames; the lens is fitted to within 0.2 px.
// The replay starts at the true pose and the run at the planned one, 5 mm away, so only aligned errors
// compare.
TEST_F(Exchange, ARunReplayedFromItsEurocExportHasNearlyTheSameScores) {
  ok("replay e --out back");
  for (const char* name : {"ate_se3_rmse_m", "ate_yaw_rmse_m"})
    EXPECT_NEAR(value("back", name), value("r/seed-1", name), 1e-3) << name;
}

TEST_F(Exchange, ATruthThatBeginsLateOrHasOnlyPositionsGivesNearlyTheSameErrors) {
  ok("replay e --out back");
  shell("cd e/mav0/state_groundtruth_estimate0 && sed -i 2,300d data.csv");
  ok("replay e --out late");
  shell("cd e/mav0/state_groundtruth_estimate0 && cut -d, -f1-4 data.csv >p && mv p data.csv");
  ok("replay e --out positions");
  ok("report positions --out positions.html");
  EXPECT_NEAR(value("late", "end_yaw_error_deg"), value("back", "end_yaw_error_deg"), 0.3);
  EXPECT_NEAR(value("positions", "ate_se3_rmse_m"), value("late", "ate_se3_rmse_m"), 1e-3);
  EXPECT_THAT(reason("positions", "end_yaw_error_deg"), Has("only positions"));
  EXPECT_THAT(ok("score positions"), Has("truth     positions/truth.tum: timestamp[s] tx ty tz, "));
}

TEST_F(Exchange, TheScoresOfARunMatchThoseThatNumpyComputesFromItsFiles) {
  EXPECT_THAT(shell("/usr/bin/python3 " GAITSLAM_SOURCE_DIR "/tests/tools/score_oracle.py unused r/seed-1")
                  .ends(0)
                  .out,
              Has(" 0 differ"));
}

TEST_F(Exchange, AFolderWithoutTruthIsNotScoredAndOneWithoutAPlanOnlyUpToScale) {
  expect_refused(
      {{"replay e --out late 'errors.faults=[{frames_lost: {from_s: 300}}]'",
        "<argument>:1:1: errors.faults: frames_lost: never happens: it starts at 300 s, the walk ends at"}});
  shell("mv e/mav0/state_groundtruth_estimate0 truth");
  ok("replay e --out blind");
  EXPECT_EQ(reason("blind", "rmse_m"), "the run has no true pose");
  EXPECT_FALSE(text_of("blind/estimate.tum").empty());
  shell("mv truth e/mav0/state_groundtruth_estimate0 && rm -r e/mav0/plan0 e/mav0/legs0");
  EXPECT_THAT(ok("replay e --out back"), Has("\n  ate_sim3_rmse_m  "));
  EXPECT_LT(value("back", "ate_sim3_rmse_m"), 0.05);
  EXPECT_THAT(reason("back", "rmse_m"), Has("do not determine the scale"));
}

TEST_F(Exchange, WhatCannotBeReplayedOrExportedIsReportedInOneLine) {
  write("e/mav0/imu0/data.csv", "#timestamp [ns],wx,wy,wz\n12,0,0,0\n11,0,0,0\n");
  expect_refused({{"replay e --out back",
                   "gaitslam: e/mav0/imu0/data.csv:3:1: the stamp is not after the previous one: it is 1e-09 "
                   "s earlier\n"},
                  {"replay e/mav0 --out back", "or one in the EuRoC/ASL layout (with mav0/)"},
                  {"export r/seed-1 --format rosbag",
                   "--format: expected one of euroc, tum, mcap, orbslam3, openvins, not 'rosbag'\n"},
                  {"export r --format mcap", "r: has no recording/, expected the folder of a run\n"},
                  {"export r/seed-1 --format mcap --out e", "e: already exists; --force replaces"}});
}

TEST_F(Exchange, AReplayFailsIfReadingsOrImagesNeverCount) {
  for (const auto& [edit, cause] :
       {std::pair{"awk -F, -v OFS=, 'NR > 1 {$2 = $3 = $4 = 5} 1' imu0/data.csv >x && mv x imu0/data.csv",
                  "sensor_unused: the filter accepted gyro in none of the "},
        {"ffmpeg -v error -f lavfi -i color=gray:s=320x240 -frames:v 1 -pix_fmt gray x.png && "
         "for f in cam0/data/*; do cp x.png $f; done",
         "diverged: tracking lost: the image is flat"}}) {
    shell(std::string("rm -rf e && cp -r r/e e && cd e/mav0 && ") + edit).ends(0);
    EXPECT_THAT(gaitslam("replay e --out back --force").ends(3).err, Has(cause)) << edit;
  }
}

TEST_F(Exchange, AVideoHasAPictureForEachFrame) {
  ok("video r/seed-1 --out v.webm");
  const auto rows = text_of("r/seed-1/frames.csv");
  EXPECT_EQ(shell("ffprobe -v error -count_packets -select_streams v -show_entries "
                  "stream=width,height,nb_read_packets -of csv=p=0 v.webm")
                .out,
            "1280,480," + std::to_string(std::ranges::count(rows, '\n') - 1) + "\n");
  expect_refused({{"video r/seed-1 --out v.webm", "v.webm: already exists; --force replaces it"},
                  {"video r/seed-1 --out v.gif", "--out: expected a .mp4 or .webm file, not 'v.gif'"}});
  shell("cp -r r/seed-1 x; sed -i 's/^estimator:.*/estimator: {program: [there]}/' x/scenario.yaml");
  EXPECT_THAT(refusal("video x --out x.webm"), Has("x: was made by the external estimator there"));
}

// A limit on file size, in blocks of 512 bytes, stands for a full disk.
TEST_F(Exchange, AVideoThatCannotBeWrittenDoesNotReplaceAnExistingOne) {
  write("stand.yaml", scenario_of("{stand: {duration_s: 0.1}}", "rate_hz: 3"));
  ok("run stand.yaml --out s");
  for (const std::string video : {"v.mp4", "v.webm"}) {
    ok("video s/seed-1 --out " + video);
    const std::string whole = text_of(video);
    const Ran ran = shell("trap '' XFSZ; ulimit -f " + std::to_string(whole.size() / 1024) +
                          "; exec " GAITSLAM_PROGRAM " video s/seed-1 --force --out " + video)
                        .ends(2);
    EXPECT_THAT(ran.err, MatchesRegex("gaitslam: ffmpeg failed: [^\n]*: File too large\n"));
    EXPECT_TRUE(text_of(video) == whole) << video;
  }
}

}  // namespace
}  // namespace tests
