// A run exported in another program's format and replayed as a third-party recording.
#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/tools/command_line.h"

namespace {

using testing::HasSubstr;

constexpr const char* kWalk = R"(
walk:
  commands:
    - stand: {duration_s: 0.3}
    - straight: {forward_m: 0.3, left_m: 0}
camera: {rate_hz: 10}
slam: {}
)";

// One run and one export serve all tests of the process; each changes its own copy of the export.
class Exchange : public tests::CommandLine {
 protected:
  Exchange() {
    if (!std::filesystem::exists(run_)) {
      write("walk.yaml", kWalk);
      EXPECT_EQ(gaitslam("run walk.yaml --out '" + run_.string() + "'").exit_code, 0);
      EXPECT_EQ(
          gaitslam("export '" + run_.string() + "/seed-1' --format euroc --out '" + run_.string() + "/e'")
              .exit_code,
          0);
    }
    std::filesystem::create_directory_symlink(run_, folder_ / "r");
    std::filesystem::copy(run_ / "e", folder_ / "e", std::filesystem::copy_options::recursive);
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(run_); }

  nlohmann::json metric(const std::string& folder, const std::string& name) const {
    return nlohmann::json::parse(text_of(folder + "/score.json"))["metrics"][name];
  }

  static inline const std::filesystem::path run_ =
      std::filesystem::temp_directory_path() / ("gaitslam exchange " + std::to_string(getpid()));
};

// The export gives readings of 5 ms, the run has some split at frames; the lens is fitted to 0.2 px. The
// error of a single pose, the last, differs by up to its standard deviation of 8 mm.
TEST_F(Exchange, ARunComesBackFromItsEurocExportWithNearlyTheSameScores) {
  const tests::Ran replayed = gaitslam("replay e --out back");
  EXPECT_EQ(replayed.exit_code, 0) << replayed.err;
  for (const auto& [name, tolerance_m] :
       {std::pair{"rmse_m", 0.005}, {"ate_se3_rmse_m", 0.005}, {"end_position_error_m", 0.008}})
    EXPECT_NEAR(metric("back", name)["value"].get<double>(), metric("r/seed-1", name)["value"].get<double>(),
                tolerance_m)
        << name;
}

TEST_F(Exchange, TheScoresOfARunAreThoseThatNumpyFindsInItsFiles) {
  const tests::Ran ran = shell("/usr/bin/python3 " GAITSLAM_ORACLE " unused r/seed-1");
  EXPECT_EQ(ran.exit_code, 0) << ran.out << ran.err;
  EXPECT_THAT(ran.out, HasSubstr(" 0 differ"));
}

TEST_F(Exchange, FootstepsAreKnownOfAResult) {
  const tests::Ran ran = gaitslam("score r/seed-1 -d 1 -u step --json");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("RPE 1 footsteps"));
  const tests::Ran nowhere = gaitslam("score e/nothing.tum e/nothing.tum -u step");
  EXPECT_EQ(nowhere.exit_code, 2);
  EXPECT_THAT(nowhere.err, HasSubstr("-u step: needs a result folder"));
}

TEST_F(Exchange, AFolderWithoutAPlanRunsOnVisionAndGyroAndIsScoredUpToScale) {
  std::filesystem::remove_all(folder_ / "e/mav0/plan0");
  const tests::Ran replayed = gaitslam("replay e --out back");
  EXPECT_EQ(replayed.exit_code, 0) << replayed.err;
  EXPECT_LT(metric("back", "ate_sim3_rmse_m")["value"].get<double>(), 0.05);
  EXPECT_THAT(replayed.out, HasSubstr("\n  ate_sim3_rmse_m  "));
  EXPECT_TRUE(metric("back", "rmse_m")["value"].is_null());
  EXPECT_THAT(metric("back", "rmse_m")["reason"].get<std::string>(), HasSubstr("do not determine the scale"));
}

TEST_F(Exchange, AFolderWithoutTruthGivesAnEstimateAndSaysWhyThereIsNoScore) {
  std::filesystem::remove_all(folder_ / "e/mav0/state_groundtruth_estimate0");
  EXPECT_EQ(gaitslam("replay e --out back").exit_code, 0);
  EXPECT_EQ(metric("back", "rmse_m")["reason"], "the run has no true pose");
  EXPECT_FALSE(text_of("back/estimate.tum").empty());
}

TEST_F(Exchange, WhatCannotBeReplayedOrExportedIsOneLine) {
  write("e/mav0/imu0/data.csv", "#timestamp [ns],x,y,z\n12,0,0,0\n11,0,0,0\n");
  EXPECT_EQ(refusal("replay e --out back"),
            "gaitslam: e/mav0/imu0/data.csv:3:1: the stamp is not after the one before\n");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "back"));
  EXPECT_THAT(refusal("replay e/mav0 --out back"), HasSubstr("or one in the EuRoC/ASL layout (with mav0/)"));
  EXPECT_EQ(gaitslam("export r/seed-1 --format rosbag").err,
            "gaitslam: --format: expected one of euroc, tum, mcap, orbslam3, openvins, not "
            "'rosbag'\n");
  EXPECT_EQ(gaitslam("export r --format mcap").err,
            "gaitslam: r: has no recording/: expected the folder of a run\n");
  EXPECT_EQ(gaitslam("export r/seed-1 --format mcap --out e").err,
            "gaitslam: e: exists already; --force replaces what the command writes there\n");
}

/// A change of a folder of another program, and what the replay must do with it.
struct Foreign {
  const char* edit;          ///< Python; f: the file of rows
  const char* file;          ///< below mav0
  const char* message = "";  ///< part of it; "": the estimate is that of the folder as it was
  int exit_code = 2;         ///< with a message
};

// Each is the same recording, stated otherwise, or one that cannot be replayed.
TEST_F(Exchange, AFolderIsReadByWhatItStatesOrRejectedBeforeItsFirstFrame) {
  const std::string read = "import sys; f = sys.argv[1]; r = [x.rstrip('\\n').split(',') for x in open(f)]; ",
                    write_back = "; open(f, 'w').writelines(','.join(map(str, x)) + '\\n' for x in r)";
  ASSERT_EQ(gaitslam("replay e --out plain").exit_code, 0);
  const auto expected = metric("plain", "rmse_m")["value"].get<double>();
  write("grey.pgm", "P5 320 240 255\n" + std::string(std::size_t{320} * 240, '\x80'));
  for (const Foreign& c : {
           Foreign{"r = [[x.replace('rad s', 'deg s') for x in r[0]]] + "
                   "[x[:1] + [float(y) * 57.29577951308232 for y in x[1:4]] + x[4:] for x in r[1:]]",
                   "imu0/data.csv"},
           {"r = [x[:1] + x[4:7] + x[1:4] for x in r]", "imu0/data.csv"},
           {"r = [x[:4] + x[5:8] + x[4:5] + x[8:] for x in r]", "state_groundtruth_estimate0/data.csv"},
           {"r[0][0] = '\\ufeff' + r[0][0]", "cam0/data.csv"},
           {"t = open(f).read().split('T_BS:')[0]; r = [[t + 'T_BS:\\n  - [0, 0, 1, 0.203]\\n  - [-1, 0, 0, "
            "0]\\n  - "
            "[0, -1, 0, 0.2823]\\n  - [0, 0, 0, 1]\\n' + open(f).read()[open(f).read().index('rate_hz'):]]]",
            "cam0/sensor.yaml"},
           {"r = r[:1] + [[int(x[0]) - 999999988000000000] + x[1:] for x in r[1:]]", "imu0/data.csv",
            "clock"},
           {"r = r[:1] + [x[:1] + [5, 5, 5] + x[4:] for x in r[1:]]", "imu0/data.csv",
            "sensor_unused: the filter accepted gyro in none of the ", 3},
           {"import glob; [open(x, 'wb').write(open('grey.pgm', 'rb').read()) for x in "
            "glob.glob('e/mav0/cam0/data/*')]",
            "cam0/data.csv", "diverged: tracking lost: the image is flat", 3},
       }) {
    std::filesystem::remove_all(folder_ / "e");
    std::filesystem::copy(run_ / "e", folder_ / "e", std::filesystem::copy_options::recursive);
    write("edit.py", read + c.edit + write_back);
    ASSERT_EQ(shell(std::string("/usr/bin/python3 edit.py e/mav0/") + c.file).exit_code, 0) << c.edit;
    const tests::Ran ran = gaitslam("replay e --out back --force");
    EXPECT_EQ(ran.exit_code, *c.message ? c.exit_code : 0) << c.edit << ran.err;
    if (*c.message)
      EXPECT_THAT(ran.err, HasSubstr(c.message)) << c.edit;
    else
      EXPECT_NEAR(metric("back", "rmse_m")["value"].get<double>(), expected, 1e-6) << c.edit;
  }
}

TEST_F(Exchange, AVideoHasAPictureForEachFrame) {
  EXPECT_EQ(gaitslam("video r/seed-1 --out v.webm").exit_code, 0);
  const tests::Ran probed = shell(
      "ffprobe -v error -count_packets -select_streams v -show_entries "
      "stream=width,height,nb_read_packets -of csv=p=0 v.webm");
  const auto rows = text_of("r/seed-1/frames.csv");
  EXPECT_EQ(probed.out, "1920,480," + std::to_string(std::count(rows.begin(), rows.end(), '\n') - 1) + "\n");
  EXPECT_EQ(gaitslam("video r/seed-1 --out v.webm").err,
            "gaitslam: v.webm: exists already; --force replaces it\n");
  EXPECT_EQ(gaitslam("video r/seed-1 --out v.gif").err,
            "gaitslam: --out: expected a .mp4 or .webm file, not 'v.gif'\n");
}

// A limit on file size, in blocks of 512 bytes, stands for a full disk.
TEST_F(Exchange, AVideoThatCannotBeWrittenReplacesNone) {
  write("stand.yaml", "walk: {commands: [{stand: {duration_s: 0.1}}]}\ncamera: {rate_hz: 3}\nslam: {}\n");
  ASSERT_EQ(gaitslam("run stand.yaml --out s").exit_code, 0);
  for (const std::string video : {"v.mp4", "v.webm"}) {
    ASSERT_EQ(gaitslam("video s/seed-1 --out " + video).exit_code, 0);
    const std::string whole = text_of(video);
    for (const std::size_t blocks : {std::size_t{4}, whole.size() / 1024, (whole.size() - 1) / 512}) {
      const tests::Ran ran = shell("trap '' XFSZ; ulimit -f " + std::to_string(blocks) +
                                   "; exec " GAITSLAM_PROGRAM " video s/seed-1 --force --out " + video);
      EXPECT_EQ(ran.exit_code, 2) << video << ' ' << blocks;
      EXPECT_THAT(ran.err, testing::MatchesRegex("gaitslam: ffmpeg failed: [^\n]*: File too large\n"));
      EXPECT_EQ(ran.out, "");
      EXPECT_TRUE(text_of(video) == whole) << video << ' ' << blocks;
    }
  }
}

}  // namespace
