#include "sim/stream/export.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/core/persistence.hpp>
#include <opencv2/imgcodecs.hpp>

#include "sim/stream/csv.h"
#include "sim/stream/export_parts.h"
#include "sim/stream/random.h"
#include "tests/sim/stream/temporary_folder.h"

namespace sim::stream {
namespace {

namespace fs = std::filesystem;
using slam::Stamp;
using testing::HasSubstr;

Eigen::Vector3d vector3(Random& random) { return {random.normal(), random.normal(), random.normal()}; }

Eigen::Isometry3d pose(Random& random) {
  Eigen::Isometry3d X(
      Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized());
  X.translation() = vector3(random);
  return X;
}

// The default camera at a fifth of its size.
slam::CameraIntrinsics small_camera() {
  return {64, 48, 39.4, 39.0, 31.4, 25.4, slam::OneParameterRadial{7.37e-6 * 25}};
}

cv::Mat image(Random& random) {
  cv::Mat grey(48, 64, CV_8UC1);
  for (int row = 0; row < grey.rows; ++row)
    for (int column = 0; column < grey.cols; ++column)
      grey.at<unsigned char>(row, column) = random.bits() & 255;
  return grey;
}

// Frames at 30 Hz, readings at 200 Hz split where a frame falls between; one image and one plan are missing.
slam::Observation observation(int k, Stamp& begin, Random& random) {
  slam::Observation o;
  for (o.t = Stamp(33'000'000ll * k); begin < o.t;) {
    const Stamp end = std::min(o.t, Stamp((begin.count() / 5'000'000 + 1) * 5'000'000));
    o.gyro.push_back({begin, end, vector3(random)});
    o.accelerometer.push_back({begin, end, vector3(random)});
    begin = end;
  }
  if (k != 3) o.image = image(random);
  if (k != 4) o.plan = slam::PlannedMotion{pose(random), vector3(random), vector3(random), vector3(random)};
  return o;
}

// Puts what the filter saw into files that need no reader of this project, images as bare bytes.
class Expected {
 public:
  explicit Expected(const fs::path& folder) : folder_(folder) { fs::create_directories(folder); }

  void add(const slam::Observation& seen) {
    for (std::size_t i = 0; i < seen.gyro.size(); ++i) add_imu(seen.gyro[i], seen.accelerometer[i].value);
    if (seen.plan) add("plan.csv", seen.t, seen.plan->X_PC);
    if (seen.image.empty()) return;
    line("images.csv", fmt::format("{}", written(seen.t)));
    std::ofstream(folder_ / fmt::format("{}.grey", written(seen.t)), std::ios::binary)
        .write(reinterpret_cast<const char*>(seen.image.data), static_cast<long>(seen.image.total()));
  }
  void add(const std::string& file, Stamp t, const Eigen::Isometry3d& X) const {
    line(file, fmt::format("{},{}", written(t), csv_fields(X)));
  }

 private:
  // Every 5 ms the mean over these 5 ms, at their middle.
  void add_imu(const slam::InertialSample& gyro, const Eigen::Vector3d& accelerometer) {
    const double part = static_cast<double>((gyro.end - gyro.begin).count()) / 5e6;
    gyro_ += part * gyro.value, accelerometer_ += part * accelerometer;
    if (gyro.end.count() % 5'000'000 != 0) return;
    line("imu.csv", fmt::format("{},{},{}", written(gyro.end - Stamp(2'500'000)), csv_fields(gyro_),
                                csv_fields(accelerometer_)));
    gyro_.setZero(), accelerometer_.setZero();
  }
  void line(const std::string& file, const std::string& text) const {
    std::ofstream(folder_ / file, std::ios::app) << text << '\n';
  }

  fs::path folder_;
  Eigen::Vector3d gyro_ = Eigen::Vector3d::Zero(), accelerometer_ = Eigen::Vector3d::Zero();
};

// A run of 12 frames with noise, and what its exports must hold.
class Exported : public testing::Test {
 protected:
  Exported() {
    Random random(1, "export test");
    RecordingSetup setup;
    setup.calibration = {small_camera(), pose(random)};
    RecordingWriter writer(run_.result / "recording", setup);
    Expected expected(expected_);
    SensorErrors errors(run_.errors, run_.seed);
    Stamp begin{0};
    for (int k = 0; k < 12; ++k) {
      const slam::Observation ideal = observation(k, begin, random);
      writer.add(ideal);
      for (const slam::Observation& seen : errors.take(ideal)) expected.add(seen);
      const TruePoses truth{ideal.t, pose(random), pose(random), pose(random)};
      const TrueMotion motion{ideal.t, pose(random), vector3(random)};
      writer.add(truth), writer.add(motion);
      expected.add("truth.csv", truth.t, truth.X_WC), expected.add("motion.csv", motion.t, motion.X_WG);
    }
    writer.finish();
    add_estimate(expected, random);
  }

  // Of two frames; the orientation is as uncertain about each axis, the position along each its own way.
  void add_estimate(const Expected& expected, Random& random) const {
    std::ofstream out(run_.result / "estimate_cov.txt");
    const Matrix6d P = Eigen::Vector<double, 6>(2e-6, 2e-6, 2e-6, 1e-6, 4e-6, 9e-6).asDiagonal();
    for (const Stamp t : {Stamp{0}, Stamp{33'000'000}}) {
      const Eigen::Isometry3d X = pose(random);
      out << tum_row(t, X, P);
      expected.add("slam.csv", t, X);
    }
  }

  fs::path made(ExportFormat format) const {
    const fs::path out = folder_ / std::string(kExportFormats.at(static_cast<std::size_t>(format)));
    export_run(run_, format, out, Existing::refuse);
    return out;
  }

  /// What the command prints, and its exit code at the end: "0\n" of a silent success.
  std::string ran(const std::string& command) const {
    const fs::path said = folder_ / "said";
    const int status = std::system((command + " > '" + said.string() + "' 2>&1").c_str());
    std::ifstream in(said);
    return std::string(std::istreambuf_iterator<char>(in), {}) + std::to_string(WEXITSTATUS(status)) + "\n";
  }

  std::string python(const fs::path& exported) const {
    return ran(fmt::format("/usr/bin/python3 '{}/tests/interop/read_exports.py' {} '{}' '{}'",
                           GAITSLAM_SOURCE_DIR, exported.filename().string(), exported.string(),
                           expected_.string()));
  }

  std::string node(const fs::path& mcap, const std::string& topics) const {
    return ran(fmt::format("node '{0}/tests/interop/read_mcap.cjs' '{0}/build/interop' '{1}' {2} '{3}'",
                           GAITSLAM_SOURCE_DIR, mcap.string(), topics, expected_.string()));
  }

  TemporaryFolder folder_;
  ExportedRun run_{folder_ / "result", "a walk", 7, {}};
  fs::path expected_ = folder_ / "expected";
};

TEST_F(Exported, EurocIsReadBackByNumpy) { EXPECT_EQ(python(made(ExportFormat::euroc)), "0\n"); }
TEST_F(Exported, OrbSlam3IsReadBackByNumpy) { EXPECT_EQ(python(made(ExportFormat::orbslam3)), "0\n"); }
TEST_F(Exported, KalibrIsReadBackByNumpy) { EXPECT_EQ(python(made(ExportFormat::kalibr)), "0\n"); }
TEST_F(Exported, TumIsReadBackByNumpy) { EXPECT_EQ(python(made(ExportFormat::tum)), "0\n"); }
TEST_F(Exported, KittiIsReadBackByNumpy) { EXPECT_EQ(python(made(ExportFormat::kitti)), "0\n"); }

TEST_F(Exported, TheReaderNoticesAPixelThatDiffers) {
  const fs::path out = made(ExportFormat::kalibr);
  std::fstream pixels(expected_ / fmt::format("{}.grey", written(Stamp{0})),
                      std::ios::in | std::ios::out | std::ios::binary);
  const int first = pixels.get();
  pixels.seekp(0);
  pixels.put(static_cast<char>(first ^ 1));
  pixels.close();
  EXPECT_THAT(python(out), HasSubstr("AssertionError: 1000000000000000000"));
}

// The compressed images' bytes are those of the EuRoC export, whose pixels numpy has compared.
TEST_F(Exported, McapIsReadBackByItsOwnCommunitysReader) {
  const fs::path out = made(ExportFormat::mcap);
  for (const auto& file : fs::directory_iterator(made(ExportFormat::euroc) / "mav0/cam0/data"))
    fs::copy(file, expected_);
  EXPECT_EQ(node(out / "run.mcap", "/camera/image/compressed /camera/camera_info /imu"), "0\n");
  EXPECT_EQ(YAML::LoadFile(out / "metadata.yaml")["rosbag2_bagfile_information"]["message_count"].as<int>(),
            12 + 2 + 11 + 11 + 11 + 72);  // truth, estimate, plan, images, their calibration, IMU
}

TEST_F(Exported, OpenVinsBagIsReadBackByTheMcapCommunitysReader) {
  const fs::path out = made(ExportFormat::openvins);
  EXPECT_EQ(node(out / "bag/run.mcap", "/cam0/image_raw /cam0/camera_info /imu0"), "0\n");
}

TEST_F(Exported, TheMcapReaderNoticesAByteThatDiffers) {
  const fs::path mcap = made(ExportFormat::openvins) / "bag/run.mcap";
  std::fstream file(mcap, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<long>(fs::file_size(mcap)) / 2);
  const int byte = file.peek();
  file.put(static_cast<char>(byte ^ 1));
  file.close();
  EXPECT_THAT(node(mcap, "/cam0/image_raw /cam0/camera_info /imu0"), HasSubstr("CRC"));
}

double density(double sigma) { return sigma * std::sqrt(0.005); }  // of a 5 ms reading

TEST_F(Exported, OrbSlam3sSettingsAreReadByOpenCvAsItReadsThem) {
  const fs::path out = made(ExportFormat::orbslam3);
  const cv::FileStorage settings(out / "settings.yaml", cv::FileStorage::READ);
  EXPECT_EQ(settings["Camera.type"].string(), "KannalaBrandt8");
  for (const char* real : {"Camera1.fx", "Camera1.fy", "Camera1.cx", "Camera1.cy", "Camera1.k1", "Camera1.k4",
                           "IMU.Frequency", "IMU.GyroWalk", "IMU.AccWalk", "Viewer.ViewpointF"})
    EXPECT_TRUE(settings[real].isReal()) << real;
  for (const char* whole :
       {"Camera.width", "Camera.height", "Camera.fps", "Camera.RGB", "ORBextractor.nLevels"})
    EXPECT_TRUE(settings[whole].isInt()) << whole;
  EXPECT_DOUBLE_EQ(settings["IMU.NoiseGyro"].real(), density(run_.errors.gyro.sigma_rad_s));
  EXPECT_DOUBLE_EQ(settings["IMU.NoiseAcc"].real(), density(run_.errors.accelerometer.sigma_m_s2));
  const Eigen::Isometry3d X_GC =
      RecordingReader(run_.result / "recording").setup().calibration.X_CG.inverse();
  const cv::Mat T = settings["IMU.T_b_c1"].mat();
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      EXPECT_NEAR(T.at<float>(row, column), X_GC(row, column), 1e-6);  // a float
}

TEST_F(Exported, KalibrsAndOpenVinssExtrinsicsAreEachOthersInverse) {
  const YAML::Node chain = YAML::LoadFile(made(ExportFormat::kalibr) / "camchain-imucam.yaml")["cam0"];
  const cv::FileStorage openvins(made(ExportFormat::openvins) / "kalibr_imucam_chain.yaml",
                                 cv::FileStorage::READ);
  Eigen::Matrix4d X, Y;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) {
      X(row, column) = chain["T_cam_imu"][row][column].as<double>();
      Y(row, column) = openvins["cam0"]["T_imu_cam"][row][column].real();
    }
  EXPECT_LT((X * Y - Eigen::Matrix4d::Identity()).norm(), 1e-14);
  EXPECT_EQ(X, RecordingReader(run_.result / "recording").setup().calibration.X_CG.matrix());
  EXPECT_EQ(chain["distortion_model"].as<std::string>(), "equidistant");
}

TEST_F(Exported, OpenVinssFilesAreReadByOpenCvAsItReadsThem) {
  const fs::path out = made(ExportFormat::openvins);
  const cv::FileStorage estimator(out / "estimator_config.yaml", cv::FileStorage::READ),
      imu(out / "kalibr_imu_chain.yaml", cv::FileStorage::READ);
  EXPECT_EQ(estimator["relative_config_imu"].string(), "kalibr_imu_chain.yaml");
  EXPECT_EQ(static_cast<int>(estimator["max_cameras"]), 1);
  EXPECT_DOUBLE_EQ(imu["imu0"]["gyroscope_noise_density"].real(), density(0.01));
  EXPECT_EQ(imu["imu0"]["rostopic"].string(), "/imu0");
}

// numpy works out each pixel apart from the exporter: noise differs by many grey levels a hundredth of a
// pixel aside. MCAP's readers compare with the EuRoC export's images, which numpy has compared.
TEST_F(Exported, EveryFormatHasTheLensTakenOutOfItsImagesWhereThatIsAskedFor) {
  run_.undistort = true;
  std::ofstream(expected_ / "undistorted") << "";
  const fs::path euroc = made(ExportFormat::euroc);
  EXPECT_EQ(python(euroc), "0\n");
  EXPECT_EQ(python(made(ExportFormat::orbslam3)), "0\n");
  EXPECT_EQ(python(made(ExportFormat::kalibr)), "0\n");
  EXPECT_EQ(python(made(ExportFormat::tum)), "0\n");
  for (const auto& file : fs::directory_iterator(euroc / "mav0/cam0/data")) {
    fs::copy(file, expected_);
    const cv::Mat pixels = cv::imread(file.path().string(), cv::IMREAD_GRAYSCALE);
    std::ofstream(expected_ / (file.path().stem().string() + ".grey"), std::ios::binary)
        .write(reinterpret_cast<const char*>(pixels.data), static_cast<long>(pixels.total()));
  }
  EXPECT_EQ(node(made(ExportFormat::mcap) / "run.mcap", "/camera/image/compressed /camera/camera_info /imu"),
            "0\n");
  EXPECT_EQ(node(made(ExportFormat::openvins) / "bag/run.mcap", "/cam0/image_raw /cam0/camera_info /imu0"),
            "0\n");
  const cv::FileStorage chain(folder_ / "openvins/kalibr_imucam_chain.yaml", cv::FileStorage::READ);
  EXPECT_EQ(chain["cam0"]["distortion_model"].string(), "radtan");
}

TEST_F(Exported, EachFolderSaysHowItIsUsedAndHowWellTheLensFits) {
  for (std::size_t i = 0; i < kExportFormats.size(); ++i) {
    std::ifstream in(made(static_cast<ExportFormat>(i)) / "README.md");
    const std::string text(std::istreambuf_iterator<char>(in), {});
    EXPECT_THAT(text, HasSubstr("FOLDER")) << kExportFormats[i];
    const bool pinhole = kExportFormats[i] == "tum" || kExportFormats[i] == "kitti";
    EXPECT_THAT(text, HasSubstr(pinhole ? "a pinhole of f = " : "px root mean square")) << kExportFormats[i];
  }
}

// The stamps that the rows of a text file begin with; all of one file have the same number of digits.
std::vector<std::string> stamps_of(const fs::path& file) {
  std::vector<std::string> stamps;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);)
    if (std::isdigit(static_cast<unsigned char>(line[0])))
      stamps.push_back(line.substr(0, line.find_first_of(", ")));
  return stamps;
}

TEST_F(Exported, StampsRiseInEveryFileHoweverFramesArrive) {
  run_.errors.faults = {FramesDoubled{{0.03, 0.1}}, FramesReordered{{0.15, 0.1}, 0.5},
                        FramesLost{{0.29, 0.04}}};
  Seen seen(run_.result / "recording", run_.errors, run_.seed);
  int back = 0;
  Stamp last{-1};
  while (const auto o = seen.next()) {
    back += o->t <= last;
    last = o->t;
  }
  ASSERT_GT(back, 3);
  const std::vector<std::pair<ExportFormat, std::vector<const char*>>> files{
      {ExportFormat::euroc, {"mav0/cam0/data.csv", "mav0/imu0/data.csv", "mav0/plan0/data.csv", "times.txt"}},
      {ExportFormat::tum, {"rgb.txt", "accelerometer.txt", "plan.txt", "groundtruth.txt"}},
      {ExportFormat::kitti, {"sequences/00/times.txt"}},
      {ExportFormat::kalibr, {"imu0.csv", "groundtruth.tum"}}};
  for (const auto& [format, names] : files)
    for (const fs::path out = made(format); const char* name : names) {
      const std::vector<std::string> stamps = stamps_of(out / name);
      EXPECT_GT(stamps.size(), 3u) << name;
      EXPECT_EQ(std::adjacent_find(stamps.begin(), stamps.end(), std::greater_equal<>()), stamps.end())
          << name;
    }
  EXPECT_TRUE(fs::exists(made(ExportFormat::mcap) / "run.mcap"));
}

TEST_F(Exported, ADamagedRecordingLeavesNoFolder) {
  fs::resize_file(run_.result / "recording/mav0/cam0/data/1000000000330000000.png", 100);
  EXPECT_THROW(made(ExportFormat::mcap), FileError);
  EXPECT_FALSE(fs::exists(folder_ / "mcap"));
}

TEST(OtherLens, TheEquidistantModelFitsTheOneParameterLensWhereBothFocalLengthsAreTheSame) {
  const FittedCamera fitted =
      fit_equidistant({320, 240, 197, 197, 157, 127, slam::OneParameterRadial{7.37e-6}});
  EXPECT_LT(fitted.rms_px, 0.002);
  EXPECT_LT(fitted.largest_px, 0.02);
}

// The head camera's focal lengths differ by 1 %. Its lens bends by the distance in px, the equidistant one by
// the angle: along u and v they part, most at the corners.
TEST(OtherLens, TheHeadCamerasLensIsFittedAsWellAsItsUnequalFocalLengthsAllow) {
  const FittedCamera fitted = fit_equidistant(slam::CameraIntrinsics{});
  EXPECT_NEAR(fitted.rms_px, 0.066, 0.001);
  EXPECT_NEAR(fitted.largest_px, 0.193, 0.002);
}

TEST(OtherLens, APinholeIsFittedByItsOwnFocalLengths) {
  const FittedCamera fitted = fit_equidistant({320, 240, 160, 160, 160, 120, slam::OneParameterRadial{0}});
  EXPECT_NEAR(fitted.camera.fu_px, 160, 0.02);
  EXPECT_LT(fitted.largest_px, 0.02);  // tan θ is no polynomial of degree nine
}

}  // namespace
}  // namespace sim::stream
