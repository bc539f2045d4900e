#include "sim/export/export.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <opencv2/core/persistence.hpp>
#include <stdexcept>

#include "sim/recording/filter_input.h"
#include "sim/trajectory_score/report.h"
#include "tests/sim/export/exported.h"

namespace sim::exports {
namespace {

using testing::ThrowsMessage;

// Contents of metadata.yaml.
YAML::Node bag_of(const fs::path& folder) {
  return YAML::LoadFile(folder / "metadata.yaml")["rosbag2_bagfile_information"];
}

// As recorded, and without distortion: numpy computes each pixel independently, as noise differs by many grey
// levels a hundredth of a pixel aside.
TEST_F(Exported, EachFormatIsReadBackByNumpyAndTheMcapProjectsReader) {
  if (!reader_missing().empty()) GTEST_SKIP() << reader_missing();
  for (run_.undistort = false;; run_.undistort = true) {
    for (const std::string& format : export_formats()) EXPECT_EQ(difference(format), "") << format;
    const cv::FileStorage chain(folder_ / "openvins/kalibr_imucam_chain.yaml", cv::FileStorage::READ);
    EXPECT_EQ(chain["cam0"]["distortion_model"].string(), run_.undistort ? "radtan" : "equidistant");
    if (run_.undistort) break;
    files::write_text(expected_ / "undistorted", "");
  }
}

TEST_F(Exported, EachFormatsTruthIsThatOfTheResultInItsFrameAndOnItsClock) {
  std::string truth;
  for (const files::TimedPose& pose : recording::read_truth(run_.result / "recording").camera)
    truth += files::tum_row(pose.t, pose.X);
  files::write_text(run_.result / "truth.tum", truth);
  trajectory_score::Options options;
  options.pairing.offset_s = -1e9;
  for (const char* file : {"tum/groundtruth.txt", "orbslam3/groundtruth.tum", "openvins/groundtruth.tum"}) {
    const fs::path exported = folder_ / file;
    made(exported.parent_path().filename());
    const auto report = trajectory_score::score_files(run_.result / "truth.tum", exported, options);
    EXPECT_EQ(report.files.pairs.size(), 12U) << file;
    EXPECT_LT(std::get<trajectory_score::ErrorStatistics>(report.rows.front().statistics).max, 1e-9) << file;
    EXPECT_THAT([&] { trajectory_score::score_files(run_.result / "truth.tum", exported, {}); },
                ThrowsMessage<std::invalid_argument>(
                    HasSubstr("with --t-offset -1000000000 12 of its poses have a true one")));
  }
}

TEST_F(Exported, ATruthOfPositionsAloneScoresPositionsOnly) {
  const fs::path poses = made("tum") / "groundtruth.txt", positions = folder_ / "positions.csv";
  std::string text = "#timestamp [s],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m]\n";
  for (const files::TumRow& row : files::read_tum(poses))
    text += fmt::format("{}.{:09},{}\n", row.t.count() / 1'000'000'000, row.t.count() % 1'000'000'000,
                        files::csv_fields(Eigen::Vector3d(row.X.translation())));
  files::write_text(positions, text);
  trajectory_score::Options options;
  const auto report = trajectory_score::score_files(positions, poses, options);
  EXPECT_LT(std::get<trajectory_score::ErrorStatistics>(report.rows.front().statistics).max, 1e-9);
  EXPECT_THAT(trajectory_score::json_text(report), HasSubstr("a file has positions only"));
  options.relation = trajectory_score::Relation::angle_deg;
  EXPECT_THAT([&] { trajectory_score::score_files(positions, poses, options); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("it needs orientations")));
}

TEST_F(Exported, WithoutTruthNoFileHasIt) {
  run_.with_truth = false;
  for (const std::string& format : export_formats())
    for (const auto& file : fs::recursive_directory_iterator(made(format))) {
      const std::string path = fs::relative(file.path(), folder_.path());
      for (const char* word : {"truth", "poses", "estimate.txt"})
        EXPECT_EQ(path.find(word), path.npos) << path;
    }
  std::map<std::string, int> counts;
  for (const YAML::Node& topic : bag_of(folder_ / "mcap")["topics_with_message_count"])
    counts[topic["topic_metadata"]["name"].as<std::string>()] = topic["message_count"].as<int>();
  EXPECT_EQ(counts["/ground_truth/pose"], 0);
  for (const char* topic :
       {"/ground_truth/tf", "/ground_truth/path", "/slam/path", "/slam/map", "/slam/pose"})
    EXPECT_EQ(counts.count(topic), 0u) << topic;
  EXPECT_EQ(counts["/tf"], 10 + 11);  // the planned camera, and the robot's links from its waist
}

TEST_F(Exported, MetadataOfABagCountsItsMessagesAndStatesWhichTopicsAreLatched) {
  const YAML::Node bag = bag_of(made("mcap"));
  EXPECT_EQ(bag["message_count"].as<int>(),
            12 + 2 + 10 + 10 + 10 + 72     // truth, estimate, plan, images, their calibration, IMU
                + 10 + 12 + 2 + 3 * 2 + 2  // frames, true ones, fixed ones, paths, maps
                + 22 + 2 * 22              // joints, wrenches
                + 1 + 11);                 // the robot, its links
  std::vector<std::string> transient_local;
  for (const YAML::Node& topic : bag["topics_with_message_count"])
    for (const YAML::Node& qos :
         YAML::Load(topic["topic_metadata"]["offered_qos_profiles"].as<std::string>()))
      if (qos["durability"].as<int>() == 1)
        transient_local.push_back(topic["topic_metadata"]["name"].as<std::string>());
  EXPECT_THAT(transient_local,
              testing::UnorderedElementsAre("/tf_static", "/ground_truth/tf_static", "/robot_description"));
}

TEST_F(Exported, AByteOfABagThatDiffersIsNoticedByItsReader) {
  if (!reader_missing().empty()) GTEST_SKIP() << reader_missing();
  const fs::path mcap = made("openvins") / "bag/run.mcap";
  std::string bytes = files::read_text(mcap);
  bytes[bytes.size() / 2] ^= 1;
  files::write_text(mcap, bytes);
  EXPECT_THAT(messages(mcap), HasSubstr("CRC"));
}

TEST_F(Exported, EachFormatReportsItsProgressAndStatesTheCommandAndTheLens) {
  for (const std::string& format : export_formats()) {
    std::vector<double> parts;
    run_.progress = [&](double part) { parts.push_back(part); };
    const std::string text = files::read_text(made(format) / "README.md");
    EXPECT_THAT(text, HasSubstr("FOLDER")) << format;
    EXPECT_THAT(text, HasSubstr(format == "tum" ? "an ideal pinhole" : "px root mean square")) << format;
    EXPECT_GT(parts.size(), 2u) << format;
    EXPECT_TRUE(std::is_sorted(parts.begin(), parts.end())) << format;
    EXPECT_EQ(parts.back(), 1) << format;
  }
}

TEST_F(Exported, AnUnknownFormatOrADamagedRecordingLeavesNoFolder) {
  EXPECT_THROW(made("kalibr"), std::out_of_range);
  EXPECT_FALSE(fs::exists(folder_ / "kalibr"));
  fs::resize_file(run_.result / "recording/mav0/cam0/data/1000000000330000000.png", 100);
  EXPECT_THROW(made("mcap"), files::FileError);
  EXPECT_FALSE(fs::exists(folder_ / "mcap"));
}

// The stamps at the start of the rows of a text file; all of one file have the same number of digits.
std::vector<std::string> stamps_of(const fs::path& file) {
  std::vector<std::string> stamps;
  std::istringstream in(files::read_text(file));
  for (std::string line; std::getline(in, line);)
    if (std::isdigit(static_cast<unsigned char>(line[0])))
      stamps.push_back(line.substr(0, line.find_first_of(", ")));
  return stamps;
}

TEST_F(Exported, StampsRiseInEveryFileHoweverFramesArrive) {
  run_.errors.faults = {sensor_errors::FramesDoubled{{{0.03, 0.1}}},
                        sensor_errors::FramesReordered{{{0.15, 0.1}, 0.5}},
                        sensor_errors::FramesLost{{{0.29, 0.04}}}};
  recording::FilterInput input(run_.result / "recording", run_.errors, run_.seed);
  int back = 0;
  Stamp last{-1};
  while (const auto o = input.next()) {
    back += o->t <= last;
    last = o->t;
  }
  ASSERT_GT(back, 3);
  const std::vector<std::pair<std::string, std::vector<const char*>>> files{
      {"euroc", {"mav0/cam0/data.csv", "mav0/imu0/data.csv", "mav0/plan0/data.csv", "times.txt"}},
      {"tum", {"rgb.txt", "accelerometer.txt", "plan.txt", "groundtruth.txt"}}};
  for (const auto& [format, names] : files)
    for (const fs::path out = made(format); const char* name : names) {
      const std::vector<std::string> stamps = stamps_of(out / name);
      EXPECT_GT(stamps.size(), 3u) << name;
      EXPECT_EQ(std::adjacent_find(stamps.begin(), stamps.end(), std::greater_equal<>()), stamps.end())
          << name;
    }
  EXPECT_TRUE(fs::exists(made("mcap") / "run.mcap"));
}

TEST(LensConversion, TheEquidistantModelFitsTheOneParameterLensWhereBothFocalLengthsAreTheSame) {
  const rig::FittedCamera fitted =
      rig::fit_equidistant({320, 240, 197, 197, 157, 127, slam::OneParameterRadial{7.37e-6}});
  EXPECT_LT(fitted.rms_px, 0.002);
  EXPECT_LT(fitted.largest_px, 0.02);
}

// The head camera's focal lengths differ by 1 %. Its lens bends by the distance in px, the equidistant one by
// the angle: along u and v they part, most at the corners.
TEST(LensConversion, TheHeadCamerasLensIsFittedAsWellAsItsUnequalFocalLengthsAllow) {
  const rig::FittedCamera fitted = rig::fit_equidistant(slam::CameraIntrinsics{});
  EXPECT_NEAR(fitted.rms_px, 0.066, 0.001);
  EXPECT_NEAR(fitted.largest_px, 0.193, 0.002);
}

}  // namespace
}  // namespace sim::exports
