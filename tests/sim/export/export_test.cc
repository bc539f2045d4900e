#include "sim/export/export.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/core/persistence.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "sim/export/export_context.h"
#include "sim/files/csv.h"
#include "sim/files/text.h"
#include "sim/recording/filter_input.h"
#include "sim/sensor_errors/random.h"
#include "sim/trajectory_score/report.h"
#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/recording/random_readings.h"

namespace sim::exports {
namespace {

namespace fs = std::filesystem;
using slam::Stamp, testing::HasSubstr, testing::ThrowsMessage;
using tests::random_image, tests::random_pose, tests::random_vector;

// The default camera at a fifth of its size.
slam::CameraIntrinsics small_camera() {
  return {64, 48, 39.4, 39.0, 31.4, 25.4, slam::OneParameterRadial{7.37e-6 * 25}};
}

// Frames at 30 Hz, readings at 200 Hz split by frames in between; one image and one plan are missing.
slam::Observation observation(int k, Stamp& begin, sensor_errors::Random& random) {
  slam::Observation o;
  for (o.t = Stamp(33'000'000ll * k); begin < o.t;) {
    const Stamp end = std::min(o.t, Stamp((begin.count() / 5'000'000 + 1) * 5'000'000));
    o.gyro.push_back({begin, end, random_vector(random)});
    o.accelerometer.push_back({begin, end, random_vector(random)});
    begin = end;
  }
  if (k != 3) o.image = random_image({64, 48}, random);
  if (k != 4)
    o.plan = slam::PlannedMotion{random_pose(random), random_vector(random), random_vector(random),
                                 random_vector(random)};
  return o;
}

void write_pixels(const fs::path& file, const cv::Mat& image) {
  files::write_text(file, {reinterpret_cast<const char*>(image.data), image.total()});
}

// Writes the input of the filter to files that need no reader of this project, images as bare bytes.
class Expected {
 public:
  explicit Expected(const fs::path& folder) : folder_(folder) { fs::create_directories(folder); }

  void add(const slam::Observation& input) {
    for (std::size_t i = 0; i < input.gyro.size(); ++i) {  // every 5 ms their mean, at their middle
      const slam::InertialSample& gyro = input.gyro[i];
      const double part = static_cast<double>((gyro.end - gyro.begin).count()) / 5e6;
      gyro_ += part * gyro.value, accelerometer_ += part * input.accelerometer[i].value;
      if (gyro.end.count() % 5'000'000 != 0) continue;
      add("imu.csv", gyro.end - Stamp(2'500'000), gyro_, accelerometer_);
      gyro_.setZero(), accelerometer_.setZero();
    }
    if (input.plan) add("plan.csv", input.t, input.plan->X_PC);
    if (input.image.empty()) return;
    add("images.csv", input.t);
    write_pixels(folder_ / fmt::format("{}.grey", recording::file_stamp(input.t)), input.image);
  }
  /// A row of a time with vectors or poses.
  void add(const std::string& file, Stamp t, const auto&... values) const {
    line(file, (fmt::format("{}", recording::file_stamp(t)) + ... + ("," + files::csv_fields(values))));
  }
  void line(const std::string& file, const std::string& text) const {
    std::ofstream(folder_ / file, std::ios::app) << text << '\n';
  }

 private:
  fs::path folder_;
  Eigen::Vector3d gyro_ = Eigen::Vector3d::Zero(), accelerometer_ = Eigen::Vector3d::Zero();
};

// A run of 12 frames with noise, and the expected content of its exports.
class Exported : public testing::Test {
 protected:
  Exported() {
    sensor_errors::Random random(1, "export test");
    recording::RecordingSetup setup;
    setup.calibration = {small_camera(), random_pose(random)};
    setup.joints = {"hip", "knee"};
    expected_X_CG_ = setup.calibration.X_CG;
    recording::RecordingWriter writer(run_.result / "recording", setup);
    Expected expected(expected_);
    sensor_errors::SensorErrors errors(run_.errors, run_.seed);
    Stamp begin{0};
    for (int k = 0; k < 12; ++k) {
      const slam::Observation ideal = observation(k, begin, random);
      writer.add(ideal);
      for (const slam::Observation& input : errors.process(ideal)) expected.add(input);
      const recording::TruePoses truth{ideal.t, random_pose(random), random_pose(random),
                                       random_pose(random)};
      const recording::TrueMotion motion{ideal.t, random_pose(random), random_vector(random)};
      writer.add(truth), writer.add(motion);
      add_body(writer, expected, ideal.t, random);
      expected.add("waist.csv", truth.t, truth.X_WB);
      expected.add("truth.csv", truth.t, truth.X_WC), expected.add("motion.csv", motion.t, motion.X_WG);
    }
    writer.finish();
    expected.add("X_CG.csv", Stamp{0}, expected_X_CG_);
    add_estimate(expected, random);
    const std::string map =
        "#timestamp [ns],id,x,y,z\n0,7,1.5,-2.25,0.5\n0,9,3,4,5\n99000000,7,1.25,-2.5,0.75\n";
    files::write_text(run_.result / "map_over_time.csv", map);
    files::write_text(expected_ / "map.csv", map.substr(map.find('\n') + 1));
  }

  // Feet at the frame; two readings of joints and forces since the previous one. The links are at the last.
  static void add_body(recording::RecordingWriter& writer, const Expected& expected, Stamp t,
                       sensor_errors::Random& random) {
    recording::TrueFeet feet;
    feet.t = t;
    feet.left.truth = random_vector(random), feet.right.truth = random_vector(random);
    writer.add(feet);
    expected.add("left_foot.csv", t, on_ground(feet.left.truth));
    expected.add("right_foot.csv", t, on_ground(feet.right.truth));
    for (const Stamp before : {Stamp{7'000'000}, Stamp{2'000'000}}) {
      if (t < before) continue;
      recording::BodyReading reading{t - before, random_vector(random).head(2), {}, {}};
      for (recording::BodyReading::Wrench* wrench : {&reading.left, &reading.right})
        wrench->force = random_vector(random), wrench->torque = random_vector(random);
      writer.add(reading);
      const std::string joints =
          fmt::format("{},{},{}", recording::file_stamp(reading.t), reading.q[0], reading.q[1]);
      expected.line("joints.csv", joints);
      if (before == Stamp{2'000'000}) expected.line("links.csv", joints);
      expected.add("left_wrench.csv", reading.t, reading.left.force, reading.left.torque);
      expected.add("right_wrench.csv", reading.t, reading.right.force, reading.right.torque);
    }
  }
  static Eigen::Isometry3d on_ground(const Eigen::Vector3d& foot) {
    const double c = std::cos(foot.z()), s = std::sin(foot.z());
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() << c, -s, 0, s, c, 0, 0, 0, 1;
    X.translation() << foot.x(), foot.y(), 0;
    return X;
  }

  // Two frames; the orientation is equally uncertain about each axis, the position is not.
  void add_estimate(const Expected& expected, sensor_errors::Random& random) const {
    std::ofstream out(run_.result / "estimate_cov.txt");
    const files::Matrix6d P = Eigen::Vector<double, 6>(2e-6, 2e-6, 2e-6, 1e-6, 4e-6, 9e-6).asDiagonal();
    for (const Stamp t : {Stamp{0}, Stamp{33'000'000}}) {
      const Eigen::Isometry3d X = random_pose(random);
      out << files::tum_row(t, X, P);
      expected.add("slam.csv", t, X);
    }
  }

  fs::path made(const std::string& format) const {
    const fs::path out = folder_ / format;
    export_run(run_, format, out, files::Existing::reject);
    return out;
  }

  YAML::Node bag_of(const std::string& format) const {
    return YAML::LoadFile(folder_ / format / "metadata.yaml")["rosbag2_bagfile_information"];
  }

  /// The output of a command, followed by its exit code: "0\n" for a silent success.
  std::string run_command(const std::string& command) const {
    const fs::path output = folder_ / "output";
    const int status = std::system((command + " > '" + output.string() + "' 2>&1").c_str());
    return files::read_text(output) + std::to_string(WEXITSTATUS(status)) + "\n";
  }

  std::string python(const fs::path& exported) const {
    return run_command(fmt::format("/usr/bin/python3 '{}/tests/interop/read_exports.py' {} '{}' '{}'",
                                   GAITSLAM_SOURCE_DIR, exported.filename().string(), exported.string(),
                                   expected_.string()));
  }

  std::string node(const fs::path& mcap, const std::string& topics) const {
    return run_command(
        fmt::format("node '{0}/tests/interop/read_mcap.cjs' '{0}/build/interop' '{1}' {2} '{3}'",
                    GAITSLAM_SOURCE_DIR, mcap.string(), topics, expected_.string()));
  }

  /// Empty if the reader of MCAP files from npm is installed, otherwise the reason.
  static std::string reader_missing() {
    const bool installed =
        fs::exists(fs::path(GAITSLAM_SOURCE_DIR) / "build/interop/node_modules/.installed");
    return installed || std::getenv("CI") != nullptr ? ""
                                                     : "tools/test.sh could not install the reader from npm";
  }

  files::TemporaryFolder folder_;
  static std::shared_ptr<const RobotDescription> robot() {
    const auto poses = [](const Eigen::VectorXd& q) {
      return std::vector{Eigen::Isometry3d(Eigen::Translation3d(q[0], 0, 0)),
                         Eigen::Isometry3d(Eigen::Translation3d(0, q[1], 0))};
    };
    return std::make_shared<RobotDescription>(RobotDescription{"<robot/>", {"thigh", "shin"}, poses});
  }

  ExportedRun run_{folder_ / "result", "a walk", 7, {}, true, false, robot()};
  fs::path expected_ = folder_ / "expected";
  Eigen::Isometry3d expected_X_CG_ = Eigen::Isometry3d::Identity();
};

TEST_F(Exported, ImagesAndReadingsAreReadBackByNumpy) {
  for (const char* format : {"euroc", "orbslam3", "tum", "openvins"})
    EXPECT_EQ(python(made(format)), "0\n") << format;
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
  for (const YAML::Node& topic : bag_of("mcap")["topics_with_message_count"])
    counts[topic["topic_metadata"]["name"].as<std::string>()] = topic["message_count"].as<int>();
  EXPECT_EQ(counts["/ground_truth/pose"], 0);
  for (const char* topic :
       {"/ground_truth/tf", "/ground_truth/path", "/slam/path", "/slam/map", "/slam/pose"})
    EXPECT_EQ(counts.count(topic), 0u) << topic;
  EXPECT_EQ(counts["/tf"], 2 * 11);  // the planned camera, and the robot's links from its waist
}

// The compressed images are those of the EuRoC export, which numpy compares in another test.
TEST_F(Exported, McapIsReadBackByTheMcapProjectsReader) {
  if (!reader_missing().empty()) GTEST_SKIP() << reader_missing();
  const fs::path out = made("mcap");
  for (const auto& file : fs::directory_iterator(made("euroc") / "mav0/cam0/data")) fs::copy(file, expected_);
  EXPECT_EQ(node(out / "run.mcap", "/camera/image/compressed /camera/camera_info /imu"), "0\n");
  const YAML::Node bag = bag_of("mcap");
  EXPECT_EQ(bag["message_count"].as<int>(),
            12 + 2 + 11 + 11 + 11 + 72     // truth, estimate, plan, images, their calibration, IMU
                + 11 + 12 + 2 + 3 * 2 + 2  // frames, true ones, fixed ones, paths, maps
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

TEST_F(Exported, OpenVinsBagIsReadBackAndAByteThatDiffersIsNoticed) {
  if (!reader_missing().empty()) GTEST_SKIP() << reader_missing();
  const fs::path mcap = made("openvins") / "bag/run.mcap";
  const std::string topics = "/cam0/image_raw /cam0/camera_info /imu0";
  EXPECT_EQ(node(mcap, topics), "0\n");
  std::fstream file(mcap, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<long>(fs::file_size(mcap)) / 2);
  const int byte = file.peek();
  file.put(static_cast<char>(byte ^ 1));
  file.close();
  EXPECT_THAT(node(mcap, topics), HasSubstr("CRC"));
}

double density(double sigma) { return sigma * std::sqrt(0.005); }  // of a 5 ms reading

TEST_F(Exported, OrbSlam3SettingsAreReadByOpenCv) {
  const fs::path out = made("orbslam3");
  const cv::FileStorage settings(out / "settings.yaml", cv::FileStorage::READ);
  EXPECT_EQ(settings["Camera.type"].string(), "KannalaBrandt8");
  for (const char* real : {"Camera1.fx", "Camera1.k4", "IMU.Frequency", "IMU.GyroWalk", "Viewer.ViewpointF"})
    EXPECT_TRUE(settings[real].isReal()) << real;
  for (const char* whole : {"Camera.width", "Camera.fps", "Camera.RGB", "ORBextractor.nLevels"})
    EXPECT_TRUE(settings[whole].isInt()) << whole;
  EXPECT_DOUBLE_EQ(settings["IMU.NoiseGyro"].real(), density(run_.errors.gyro.sigma_rad_s));
  EXPECT_DOUBLE_EQ(settings["IMU.NoiseAcc"].real(), density(run_.errors.accelerometer.sigma_m_s2));
  const Eigen::Isometry3d X_GC = expected_X_CG_.inverse();
  const cv::Mat T = settings["IMU.T_b_c1"].mat();
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      EXPECT_NEAR(T.at<float>(row, column), X_GC(row, column), 1e-6);  // a float
}

TEST_F(Exported, OpenVinsConfigurationIsReadByOpenCv) {
  const fs::path out = made("openvins");
  const cv::FileStorage estimator(out / "estimator_config.yaml", cv::FileStorage::READ),
      imu(out / "kalibr_imu_chain.yaml", cv::FileStorage::READ);
  EXPECT_EQ(estimator["relative_config_imu"].string(), "kalibr_imu_chain.yaml");
  EXPECT_EQ(estimator["track_frequency"].real(), 31) << "above the rate of the camera";
  EXPECT_DOUBLE_EQ(imu["imu0"]["gyroscope_noise_density"].real(), density(0.01));
  EXPECT_EQ(imu["imu0"]["rostopic"].string(), "/imu0");
  const cv::FileStorage chain(out / "kalibr_imucam_chain.yaml", cv::FileStorage::READ);
  const Eigen::Isometry3d X_GC = expected_X_CG_.inverse();
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      EXPECT_NEAR(chain["cam0"]["T_imu_cam"][row][column].real(), X_GC(row, column), 1e-14);
  EXPECT_EQ(chain["cam0"]["distortion_model"].string(), "equidistant");
}

// numpy computes each pixel independently: noise differs by many grey levels a hundredth of a
// pixel aside. MCAP's readers compare with the EuRoC export's images, which numpy has compared.
TEST_F(Exported, EveryFormatHasUndistortedImagesOnRequest) {
  if (!reader_missing().empty()) GTEST_SKIP() << reader_missing();
  run_.undistort = true;
  std::ofstream(expected_ / "undistorted") << "";
  const fs::path euroc = made("euroc");
  EXPECT_EQ(python(euroc), "0\n");
  EXPECT_EQ(python(made("orbslam3")), "0\n");
  EXPECT_EQ(python(made("tum")), "0\n");
  for (const auto& file : fs::directory_iterator(euroc / "mav0/cam0/data")) {
    fs::copy(file, expected_);
    const cv::Mat pixels = cv::imread(file.path().string(), cv::IMREAD_GRAYSCALE);
    write_pixels(expected_ / (file.path().stem().string() + ".grey"), pixels);
  }
  EXPECT_EQ(node(made("mcap") / "run.mcap", "/camera/image/compressed /camera/camera_info /imu"), "0\n");
  EXPECT_EQ(node(made("openvins") / "bag/run.mcap", "/cam0/image_raw /cam0/camera_info /imu0"), "0\n");
  const cv::FileStorage chain(folder_ / "openvins/kalibr_imucam_chain.yaml", cv::FileStorage::READ);
  EXPECT_EQ(chain["cam0"]["distortion_model"].string(), "radtan");
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
