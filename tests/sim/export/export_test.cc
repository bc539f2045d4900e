// Exports of a short run, with and without a rig: numpy, OpenCV and npm's readers compare them with files
// that are read without this project's code.
#include "sim/export/export.h"

#include <sys/wait.h>
#include <yaml-cpp/yaml.h>

#include <nlohmann/json.hpp>
#include <opencv2/core/persistence.hpp>

#include "sim/export/export_context.h"
#include "tests/sim/recording/random_readings.h"

namespace sim::exports {
namespace {

using nlohmann::json, slam::Stamp, testing::HasSubstr;
using tests::expect_same, tests::random_image, tests::random_pose, tests::random_vector;

/// The default camera at a fifth of its size.
slam::CameraIntrinsics head_camera() {
  return {64, 48, 39.4, 39.0, 31.4, 25.4, slam::OneParameterRadial{7.37e-6 * 25}};
}

/// The sensors of the rig.
enum Sensor { kEye, kColor, kDepth, kLidar, kImu };

/// Writes the input of the filter to files that are read without this project's code, with images as raw
/// bytes.
class Expected {
 public:
  explicit Expected(const fs::path& folder) : folder_(folder) { fs::create_directories(folder); }

  void add(const slam::Observation& input) {
    for (std::size_t i = 0; i < input.gyro.size(); ++i) {  // the mean over every 5 ms, stamped in the middle
      const slam::InertialSample& gyro = input.gyro[i];
      const double part = double((gyro.end - gyro.begin).count()) / 5e6;
      gyro_ += part * gyro.value, accelerometer_ += part * input.accelerometer[i].value;
      if (gyro.end.count() % 5'000'000 != 0) continue;
      add("imu.csv", gyro.end - Stamp(2'500'000), gyro_, accelerometer_);
      gyro_.setZero(), accelerometer_.setZero();
    }
    if (input.plan) add("plan.csv", input.t, input.plan->X_PC);
    add("cam0", input.t, input.image);
    if (!input.image.empty()) add("straight", input.t, Undistortion(head_camera())(input.image));
  }
  /// IMU readings are stamped in the middle of their 10 ms interval; each point of a lidar has its own row.
  void add(const rig::RigSensor& sensor, const slam::RigReading& reading) const {
    const std::string file = sensor.name + ".csv";
    for (const slam::LidarPoint& p : reading.points)
      line(file, fmt::format("{},{},{},{},{},{}", recording::file_stamp(reading.t), p.x_m, p.y_m, p.z_m,
                             p.intensity, p.offset_ns));
    if (sensor.kind == rig::Kind::imu)
      add(file, reading.t - Stamp(5'000'000), reading.gyro, reading.accelerometer);
    add(sensor.name, reading.t, reading.image);
  }
  void add(const std::string& name, Stamp t, const cv::Mat& image) const {
    if (image.empty()) return;
    add(name + ".csv", t);
    files::write_text(folder_ / fmt::format("{}_{}", name, recording::file_stamp(t)),
                      {reinterpret_cast<const char*>(image.data), image.total() * image.elemSize()});
  }
  /// Writes a row with a time and vectors or poses.
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

/// A run of 12 frames with noise, and the expected content of its exports.
class Exported : public testing::Test {
 protected:
  using Rig = std::vector<rig::RigSensor>;
  /// change: applied to the rig; without it there is no rig.
  explicit Exported(void (*change)(Rig&) = nullptr) {
    sensor_errors::Random random(1, "export test");
    recording::RecordingSetup setup;
    setup.calibration = {head_camera(), random_pose(random)};
    setup.joints = {"hip", "knee"};
    std::vector<slam::Observation> given = tests::observations(random, 12, {64, 48}, Stamp{0});
    if (change) {
      tests::add_rig(given, random, {64, 48});
      rig_ = calibrated(tests::rig_of(random, {64, 48}));
      change(rig_);
      setup.rig = rig_;
    }
    run_.warn = [this](const std::string& what) { warnings_ += what + "\n"; };
    X_GC_ = setup.calibration.X_CG.inverse();
    recording::RecordingWriter writer(run_.result / "recording", setup);
    Expected expected(expected_);
    sensor_errors::SensorErrors errors(run_.errors, run_.seed, setup.rig);
    for (const slam::Observation& ideal : given) {
      for (const slam::RigReading& reading : ideal.rig)
        expected.add(rig_[std::size_t(reading.sensor)], reading);
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
    expected.add("X_CG.csv", Stamp{0}, setup.calibration.X_CG);
    for (const rig::RigSensor& sensor : rig_)
      expected.add("X_" + sensor.name + ".csv", Stamp{0}, sensor.X_CS);
    add_estimate(expected, random);
    add_robot(expected, random, setup.calibration.X_CG);
    const std::string map =
        "#timestamp [ns],id,x,y,z\n0,7,1.5,-2.25,0.5\n0,9,3,4,5\n99000000,7,1.25,-2.5,0.75\n";
    files::write_text(run_.result / "map_over_time.csv", map);
    files::write_text(expected_ / "map.csv", map.substr(map.find('\n') + 1));
  }

  // The gray eye 60 mm to the right of the head camera, a color camera without distortion.
  static Rig calibrated(Rig rig) {
    rig[kEye].name = "right_eye", rig[kImu].name = "chest", rig[kImu].rate_hz = 100;
    rig[kEye].X_CS = Eigen::Translation3d(0.06, 0, 0);
    rig[kEye].camera = head_camera();
    rig[kColor].camera = rig[kDepth].camera = {64, 48, 30, 30, 31.5, 23.5, slam::OneParameterRadial{0}};
    rig[kDepth].X_CS = rig[kColor].X_CS;
    rig[kLidar].lowest_rad = -1.5, rig[kLidar].highest_rad = 1.5;
    return rig;
  }

  // Feet at the time of the frame; two readings of joints and forces since the previous frame. The links are
  // posed by the last reading.
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
    export_run(run_, format, out);
    return out;
  }

  /// Runs a command. Returns its output, with its exit code if that is not 0.
  std::string run_command(const std::string& command) const {
    const fs::path output = folder_ / "output";
    const int status = std::system((command + " > '" + output.string() + "' 2>&1").c_str());
    return files::read_text(output) + (status ? "exit " + std::to_string(WEXITSTATUS(status)) : "");
  }

  /// The messages of a bag as JSON, read by npm's readers, or the readers' error.
  std::string messages(const fs::path& mcap) const {
    return run_command(fmt::format("node '{0}/tests/interop/dump_mcap.cjs' '{0}/build/interop' '{1}'",
                                   GAITSLAM_SOURCE_DIR, mcap.string()));
  }

  /// Makes an export and compares it with the expected contents using numpy. Returns what differs.
  std::string difference(const std::string& format) const {
    const fs::path out = made(format), bag = out / (format == "mcap" ? "" : "bag") / "run.mcap";
    if (fs::exists(bag)) files::write_text(expected_ / "messages.json", messages(bag));
    return run_command(fmt::format("/usr/bin/python3 '{}/tests/interop/read_exports.py' {} '{}' '{}'",
                                   GAITSLAM_SOURCE_DIR, format, out.string(), expected_.string()));
  }

  /// Empty if the reader of MCAP files from npm is installed, otherwise the reason.
  static std::string reader_missing() {
    const bool installed =
        fs::exists(fs::path(GAITSLAM_SOURCE_DIR) / "build/interop/node_modules/.installed");
    return installed || std::getenv("CI") != nullptr ? ""
                                                     : "tools/test.sh could not install the reader from npm";
  }

  // The cameras are on the shin, the other sensors on the thigh. Writes where they are.
  void add_robot(const Expected& expected, sensor_errors::Random& random, const Eigen::Isometry3d& X_CG) {
    const auto poses = [](const Eigen::VectorXd& q) {
      return std::vector{Eigen::Isometry3d(Eigen::Translation3d(q[0], 0, 0)),
                         Eigen::Isometry3d(Eigen::Translation3d(0, q[1], 0))};
    };
    RobotDescription robot{"<robot/>", {"thigh", "shin"}, poses, {}};
    std::vector<rig::RigSensor> all = rig_;
    all.resize(rig_.size() + 2);
    all[rig_.size()].name = rig::kHeadCamera;
    all.back().name = rig::kChestImu, all.back().kind = rig::Kind::imu, all.back().X_CS = X_CG;
    const Eigen::Isometry3d X_LC = random_pose(random), X_TC = random_pose(random);
    for (const rig::RigSensor& sensor : all) {
      const bool on_shin = rig::is_camera(sensor);
      robot.mountings[sensor.name] = {on_shin ? "shin" : "thigh", on_shin ? X_LC : X_TC};
      expected.add("M_" + sensor.name + ".csv", Stamp{0}, robot.mountings[sensor.name].X_LC * sensor.X_CS);
    }
    run_.robot = std::make_shared<RobotDescription>(std::move(robot));
  }

  files::TemporaryFolder folder_;
  ExportedRun run_{folder_ / "result", "a walk", 7, {}};
  fs::path expected_ = folder_ / "expected";
  Eigen::Isometry3d X_GC_;
  Rig rig_;
  mutable std::string warnings_;
};

// Contents of metadata.yaml.
YAML::Node bag_of(const fs::path& folder) {
  return YAML::LoadFile(folder / "metadata.yaml")["rosbag2_bagfile_information"];
}

TEST_F(Exported, EachFormatIsReadBackByNumpyAndTheMcapProjectsReader) {
  if (!reader_missing().empty()) GTEST_SKIP() << reader_missing();
  for (const std::string& format : export_formats()) EXPECT_EQ(difference(format), "") << format;
}

TEST_F(Exported, WithoutDistortionTheCalibrationIsThatOfThePinholeOfTheImages) {
  run_.undistort = true;
  const cv::FileStorage chain(made("openvins") / "kalibr_imucam_chain.yaml", cv::FileStorage::READ);
  EXPECT_EQ(chain["cam0"]["distortion_model"].string(), "radtan");
  const slam::CameraIntrinsics pinhole = Undistortion(head_camera()).pinhole();
  for (const auto& [i, number] :
       {std::pair(0, pinhole.fu_px), {1, pinhole.fv_px}, {2, pinhole.u0_px}, {3, pinhole.v0_px}})
    EXPECT_EQ(chain["cam0"]["intrinsics"][i].real(), number);
}

TEST_F(Exported, WithoutTruthNoFileContainsIt) {
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
  EXPECT_EQ(counts["/tf"], 11);  // the robot's links
}

TEST_F(Exported, MetadataOfABagCountsItsMessagesAndStatesWhichTopicsAreLatched) {
  const YAML::Node bag = bag_of(made("mcap"));
  EXPECT_EQ(bag["message_count"].as<int>(),
            12 + 2 + 10 + 10 + 10 + 72  // truth, estimate, plan, images, their calibration, IMU
                + 12 + 2 + 3 * 2 + 2    // true frames, fixed ones, paths, maps
                + 22 + 2 * 22           // joints, wrenches
                + 1 + 11);              // the robot, its links
  int latched = 0;
  for (const YAML::Node& topic : bag["topics_with_message_count"])
    latched += YAML::Dump(topic).find("durability: 1") != std::string::npos;
  EXPECT_EQ(latched, 3) << "which, the reader of MCAP knows";
}

TEST_F(Exported, AChangedByteOfABagIsDetectedByItsReader) {
  if (!reader_missing().empty()) GTEST_SKIP() << reader_missing();
  const fs::path mcap = made("openvins") / "bag/run.mcap";
  std::string bytes = files::read_text(mcap);
  bytes[bytes.size() / 2] ^= 1;
  files::write_text(mcap, bytes);
  EXPECT_THAT(messages(mcap), HasSubstr("CRC"));
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
  for (const std::string& line : files::lines_of(files::read_text(file)))
    if (std::isdigit(static_cast<unsigned char>(line[0])))
      stamps.push_back(line.substr(0, line.find_first_of(", ")));
  return stamps;
}

TEST_F(Exported, StampsIncreaseInEveryFileHoweverFramesArrive) {
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
      EXPECT_EQ(std::ranges::adjacent_find(stamps, std::greater_equal<>()), stamps.end()) << name;
    }
  EXPECT_TRUE(fs::exists(made("mcap") / "run.mcap"));
}

// The head camera's focal lengths differ by 1 %. Its lens distorts by the distance in px, the equidistant one
// by the angle, so the two differ along u and v, most at the corners.
TEST(LensConversion, TheEquidistantModelFitsTheOneParameterLensAsWellAsUnequalFocalLengthsAllow) {
  const rig::FittedCamera equal = rig::fit_equidistant(
                              {320, 240, 197, 197, 157, 127, slam::OneParameterRadial{7.37e-6}}),
                          head = rig::fit_equidistant(slam::CameraIntrinsics{});
  EXPECT_LT(equal.rms_px, 0.002);
  EXPECT_LT(equal.largest_px, 0.02);
  EXPECT_NEAR(head.rms_px, 0.066, 0.001);
  EXPECT_NEAR(head.largest_px, 0.193, 0.002);
}

struct RigExport : Exported {
  explicit RigExport(void (*change)(Rig&) = [](Rig&) {}) : Exported(change) {}
};

const Eigen::Isometry3d kBackwards(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY()));

// The color camera and the second eye look back; depth is the head camera's, with a different focal length.
struct RigThatLooksBack : RigExport {
  RigThatLooksBack()
      : RigExport([](Rig& rig) {
          rig[kEye].X_CS = rig[kColor].X_CS = kBackwards;
          rig[kDepth].aligned_with = "cam0";
          rig[kDepth].X_CS.setIdentity();
          rig[kDepth].camera = head_camera();
        }) {}
};

TEST_F(RigThatLooksBack, PairsDepthWithTheHeadCameraStatesItsFocalLengthAndPromisesNoStereo) {
  const fs::path tum = made("tum");
  EXPECT_THAT(warnings_, HasSubstr("no color camera shares the view of depth0: rgb/ has the images of cam0"));
  const cv::FileStorage settings(tum / "settings.yaml", cv::FileStorage::READ);
  const std::string focal = fmt::format("focal lengths {0} and {0} px", settings["Camera1.fx"].real());
  EXPECT_EQ(settings["Camera1.fx"].real(), Undistortion(head_camera()).pinhole().fu_px);
  EXPECT_THAT(files::read_text(tum / "README.md"), HasSubstr("`cam0`, gray: 64 x 48 px, " + focal));
  EXPECT_NE(
      cv::countNonZero(cv::imread((fs::directory_iterator(tum / "depth")->path()), cv::IMREAD_UNCHANGED)), 0);
  for (const auto& [format, file, key] : {std::tuple("orbslam3", "settings.yaml", "Stereo.b"),
                                          {"openvins", "estimator_config.yaml", "use_stereo: true"}}) {
    warnings_.clear();
    EXPECT_THAT(files::read_text(made(format) / file), testing::Not(HasSubstr(key)));
    EXPECT_THAT(warnings_, HasSubstr("right_eye sees 0 % of the head camera's view")) << format;
  }
}

// Turns the eye into a second color camera.
TEST_F(RigExport, DepthBelongsToTheColorCameraItIsAlignedWithOrElseToTheOneThatSeesMostOfIt) {
  for (const auto& [aligned_with, first_looks_back, second_looks_back, expected] :
       {std::tuple("right_eye", true, true, "right_eye"),
        {"rgb0", false, true, "rgb0"},
        {"cam0", true, false, "rgb0"},
        {"cam0", false, true, "right_eye"},
        {"cam0", true, true, "cam0"}}) {
    ExportContext out(run_, folder_ / "none", true);
    out.sensors[kEye].kind = rig::Kind::color;
    out.sensors[kEye].X_CS = first_looks_back ? kBackwards : Eigen::Isometry3d::Identity();
    out.sensors[kColor].X_CS = second_looks_back ? kBackwards : Eigen::Isometry3d::Identity();
    out.sensors[kDepth].aligned_with = aligned_with;
    out.sensors[kDepth].X_CS = out.sensor(rig::partner(out.sensors, out.sensor(kDepth))).X_CS;
    EXPECT_EQ(out.sensor(image_of_depth(out, kDepth)).name, expected) << aligned_with;
  }
}

// numbers: 16 in a row, or four rows.
void expect_pose(const cv::FileNode& numbers, const Eigen::Isometry3d& X) {
  for (int i = 0; i < 16; ++i)
    EXPECT_NEAR((numbers.size() == 4 ? numbers[i / 4][i % 4] : numbers[i]).real(), X(i / 4, i % 4), 1e-12);
}

// Compares the pose in a single-precision matrix.
void expect_pose(const cv::Mat& T, const Eigen::Isometry3d& X) {
  ASSERT_EQ(T.type(), CV_32FC1);
  for (int i = 0; i < 16; ++i) EXPECT_NEAR(T.at<float>(i), X(i / 4, i % 4), 1e-6);
}

double density(double sigma) { return sigma * std::sqrt(0.005); }  // from sigma of a 5 ms reading

TEST_F(RigExport, EverySensorIsReadBackByNumpyFfmpegAndTheMcapProjectsReader) {
  if (!reader_missing().empty()) GTEST_SKIP() << reader_missing();
  for (const char* format : {"euroc", "tum", "mcap"}) EXPECT_EQ(difference(format), "") << format;
}

// The keys that ORB-SLAM3's Settings.cc requires for a stereo rig with IMU, by their types there.
TEST_F(RigExport, OrbSlam3StereoSettingsHaveTheKeysThatItsReaderRequires) {
  for (const bool undistort : {false, true}) {
    run_.undistort = undistort;
    const cv::FileStorage settings(made("orbslam3") / "settings.yaml", cv::FileStorage::READ);
    std::string reals =
                    "Stereo.ThDepth IMU.NoiseGyro IMU.NoiseAcc IMU.GyroWalk IMU.AccWalk IMU.Frequency "
                    "ORBextractor.scaleFactor Viewer.ViewpointF",
                integers =
                    "Camera.height Camera.width Camera.fps Camera.RGB ORBextractor.nFeatures "
                    "ORBextractor.nLevels ORBextractor.iniThFAST ORBextractor.minThFAST";
    for (const char* camera : {"Camera1", "Camera2"}) {
      reals += fmt::format(" {0}.fx {0}.fy {0}.cx {0}.cy", camera);
      if (undistort) continue;
      reals += fmt::format(" {0}.k1 {0}.k2 {0}.k3 {0}.k4", camera);
      integers += fmt::format(" {0}.overlappingBegin {0}.overlappingEnd", camera);
    }
    EXPECT_EQ(settings["Camera.type"].string(), undistort ? "PinHole" : "KannalaBrandt8");
    std::istringstream real_keys(reals), integer_keys(integers);
    for (std::string key; real_keys >> key;)
      EXPECT_TRUE(settings[key].isReal() || settings[key].isInt()) << key;
    for (std::string key; integer_keys >> key;) EXPECT_TRUE(settings[key].isInt()) << key;
    EXPECT_EQ(settings["Camera1.fx"].real(), settings["Camera2.fx"].real());
    expect_pose(settings["Stereo.T_c1_c2"].mat(), rig_[kEye].X_CS);  // from the second camera to the first
    expect_pose(settings["IMU.T_b_c1"].mat(), X_GC_);
    EXPECT_DOUBLE_EQ(settings["IMU.NoiseGyro"].real(), density(run_.errors.gyro.sigma));
    EXPECT_DOUBLE_EQ(settings["IMU.NoiseAcc"].real(), density(run_.errors.accelerometer.sigma));
    EXPECT_GE(fs::file_size(folder_ / "orbslam3/times_stereo.txt"), 5 * 20u);  // bytes of a line
  }
}

// Time by which each clock is ahead of the head camera's.
struct RigWithClocks : RigExport {
  RigWithClocks()
      : RigExport([](Rig& rig) { rig[kEye].time_offset_s = -0.01, rig[kImu].time_offset_s = 0.02; }) {
    run_.errors.motion_time_offset_s = 0.004;  // offset of the chest IMU
  }
};

TEST_F(RigWithClocks, OpenVinsUsesBothEyesAndItsBagContainsThem) {
  const fs::path out = made("openvins");
  const cv::FileStorage estimator(out / "estimator_config.yaml", cv::FileStorage::READ),
      cameras(out / "kalibr_imucam_chain.yaml", cv::FileStorage::READ),
      imus(out / "kalibr_imu_chain.yaml", cv::FileStorage::READ);
  EXPECT_EQ(int(estimator["max_cameras"]), 2);
  EXPECT_THAT(files::read_text(out / "estimator_config.yaml"), testing::HasSubstr("use_stereo: true\n"));
  EXPECT_EQ(estimator["relative_config_imu"].string(), "kalibr_imu_chain.yaml");
  EXPECT_EQ(int(estimator["init_max_features"]), 25);
  EXPECT_EQ(imus["imu0"]["time_offset"].real(), 0);
  EXPECT_NEAR(imus["imu1"]["time_offset"].real(), 0.004 - 0.02, 1e-12);
  EXPECT_NEAR(cameras["cam1"]["timeshift_cam_imu"].real(), 0.004 + 0.01, 1e-12);
  EXPECT_DOUBLE_EQ(imus["imu0"]["gyroscope_noise_density"].real(), density(0.01));
  EXPECT_EQ(imus["imu0"]["rostopic"].string(), "/imu0");
  expect_pose(cameras["cam0"]["T_imu_cam"], X_GC_);
  expect_pose(cameras["cam1"]["T_imu_cam"], X_GC_ * rig_[kEye].X_CS);
  expect_pose(cameras["cam1"]["T_cn_cnm1"], rig_[kEye].X_CS.inverse());
  EXPECT_EQ(int(cameras["cam0"]["cam_overlaps"][0]), 1);
  EXPECT_EQ(int(cameras["cam1"]["cam_overlaps"][0]), 0);
  EXPECT_EQ(cameras["cam1"]["distortion_model"].string(), "equidistant");
  EXPECT_EQ(cameras["cam1"]["intrinsics"][3].real(), 25.4);
  EXPECT_EQ(int(cameras["cam1"]["resolution"][0]), 64);
  EXPECT_EQ(cameras["cam1"]["rostopic"].string(), "/cam1/image_raw");
  expect_pose(imus["imu1"]["T_i_b"], (X_GC_ * rig_[kImu].X_CS).inverse());
  if (!reader_missing().empty()) GTEST_SKIP() << reader_missing();
  const json all = json::parse(messages(out / "bag/run.mcap"));
  for (const char* topic : {"/cam1/image_raw", "/cam1/camera_info"})
    EXPECT_EQ(all[topic].size(), 18u) << topic;
  EXPECT_EQ(all["/cam1/image_raw"][0]["encoding"], "mono8");
  EXPECT_GT(all["/imu1"].size(), 30u);
  for (const auto& [topic, list] : all.items()) EXPECT_FALSE(topic.starts_with("/rig/")) << topic;
}

TEST(Undistortion, GrayAndColorAreInterpolatedAndDepthIsTakenFromTheNearestPixel) {
  sensor_errors::Random random(1, "undistortion test");
  const Undistortion undistort(head_camera());
  cv::Mat1b gray = random_image({64, 48}, random);
  cv::Mat1w columns(48, 64);
  for (int i = 0; i < 64; ++i) columns.col(i) = 100 * i;
  cv::Mat color;
  cv::merge(std::vector<cv::Mat>{gray, gray * 0.5, gray}, color);
  cv::Mat1b straight = undistort(gray), middle;
  cv::extractChannel(undistort(color), middle, 1);
  expect_same(middle, undistort(gray * 0.5));
  const cv::Mat1w nearest = undistort(columns);
  const slam::Camera pinhole(undistort.pinhole()), recorded(head_camera());
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u) {
      const Eigen::Vector2d p = recorded.project(pinhole.unproject({u, v})->h)->pixel;
      const int x = std::min(int(p.x()), 62), y = std::min(int(p.y()), 46);
      const double a = p.x() - x, b = p.y() - y;
      const double expected = (1 - b) * ((1 - a) * gray(y, x) + a * gray(y, x + 1)) +
                              b * ((1 - a) * gray(y + 1, x) + a * gray(y + 1, x + 1));
      EXPECT_NEAR(straight(v, u), expected, 0.5 + 1e-9);  // rounding
      EXPECT_EQ(nearest(v, u) % 100, 0);
      EXPECT_NEAR(nearest(v, u) / 100.0, p.x(), 0.5 + 1e-9);
    }
}

// The number of images per window of 0.15 m follows the speed, as long as no corner moves by more than 32 px.
TEST(TrackedImages, AreFewForASlowWalkAndMoreForFastTurns) {
  const slam::CameraIntrinsics camera{320, 240, 200, 200, 160, 120, slam::RadialTangential{}};
  const std::vector<std::tuple<double, double, double, int>> cases{{30, 0.15, 0.1, 3},  {30, 0.075, 0.1, 6},
                                                                   {60, 0.15, 0.1, 6},  {30, 1, 0.1, 1},
                                                                   {30, 0.075, 1.2, 4}, {30, 0, 0, 1}};
  for (const auto& [rate_hz, speed, turn, every] : cases) {
    WalkMotion motion{std::vector(9, speed), std::vector(9, turn)};
    if (speed == 0) motion = {};  // stands, without a gyro
    const TrackedImages tracked = tracked_images(camera, rate_hz, motion);
    EXPECT_EQ(tracked.every, every) << speed;
    EXPECT_LT(1 / tracked.frequency_hz, every / rate_hz) << "the image after " << every << " is not dropped";
    EXPECT_GT(1 / tracked.frequency_hz, (every - 1) / rate_hz);
  }
}

// A wall 2 m away behind a board, seen from 0.1 m to the left with a longer focal length.
TEST(Registration, MapsDepthToTheOtherCameraWithoutHolesKeepingTheNearestSurface) {
  const slam::CameraIntrinsics from{64, 48, 40, 40, 31.5, 23.5, slam::RadialTangential{}};
  const slam::CameraIntrinsics to{64, 48, 60, 60, 31.5, 23.5, slam::RadialTangential{}};
  cv::Mat depth(48, 64, CV_16UC1, cv::Scalar(2000));
  depth(cv::Rect(24, 20, 16, 8)) = 1000;
  const DepthRegistration registered(from, to, Eigen::Isometry3d(Eigen::Translation3d(0.1, 0, 0)));
  const cv::Mat other = registered(depth);
  // The board's columns 23.5 to 39.5 are 25.5 to 49.5 in the other camera. The wall on its left ends at 22.5;
  // on its right, it starts at 46.5 and is covered.
  for (int u = 0; u < 64; ++u) {
    EXPECT_EQ(other.at<std::uint16_t>(23, u), u < 23 || u > 49 ? 2000 : u < 26 ? 0 : 1000) << u;
    EXPECT_EQ(other.at<std::uint16_t>(2, u), 2000) << u;
  }
}

// A wall with depth noise of 5 mm, for a camera 0.2 m to the side with 1.4 times the resolution: there are
// gaps between the squares of neighboring pixels.
TEST(Registration, NoiseLeavesNoDottedColumns) {
  const slam::CameraIntrinsics from{64, 48, 40, 40, 31.5, 23.5, slam::RadialTangential{}};
  const slam::CameraIntrinsics to{64, 48, 56, 56, 31.5, 23.5, slam::RadialTangential{}};
  sensor_errors::Random random(1, "registration test");
  cv::Mat1w depth(48, 64);
  for (std::uint16_t& mm : depth) mm = std::uint16_t(1000 + 10 * random.normal());
  const DepthRegistration registered(from, to, Eigen::Isometry3d(Eigen::Translation3d(0.2, 0, 0)));
  const cv::Mat1w other = registered(depth).colRange(15, 64);
  EXPECT_EQ(cv::countNonZero(other), int(other.total()));
  EXPECT_LT(std::abs(cv::mean(other)[0] - 1000), 5);
}

}  // namespace
}  // namespace sim::exports
