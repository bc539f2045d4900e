// Exports of a rig: a second gray eye, a color camera, depth, a lidar and a further IMU, read back by OpenCV
// and by npm's readers.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core/persistence.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "sim/export/export_context.h"
#include "sim/files/text.h"
#include "sim/sensor_errors/random.h"
#include "slam/camera.h"
#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/recording/random_readings.h"

namespace sim::exports {
namespace {

namespace fs = std::filesystem;
using nlohmann::json, slam::Stamp, testing::ElementsAre;
using tests::random_image, tests::random_pose, tests::random_vector;

enum Sensor { kEye, kColor, kDepth, kLidar, kImu };

slam::CameraIntrinsics head_camera() {
  return {64, 48, 39.4, 39.0, 31.4, 25.4, slam::OneParameterRadial{7.37e-6 * 25}};
}

std::vector<rig::RigSensor> sensors(sensor_errors::Random& random) {
  std::vector<rig::RigSensor> all(5);
  const char* names[] = {"right_eye", "rgb0", "depth0", "lidar0", "chest"};
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].name = names[i], all[i].kind = static_cast<rig::Kind>(i);
    all[i].X_CS = random_pose(random);
  }
  all[kEye].X_CS = Eigen::Translation3d(0.06, 0, 0);
  all[kEye].camera = head_camera();
  all[kColor].camera = all[kDepth].camera = {40, 32, 30, 30, 19.5, 15.5, slam::OneParameterRadial{0}};
  all[kDepth].X_CS = all[kColor].X_CS;
  all[kDepth].aligned_with = "rgb0", all[kDepth].baseline_m = 0.05;
  all[kDepth].furthest_m = all[kLidar].furthest_m = 66;
  all[kLidar].rate_hz = 10, all[kImu].rate_hz = 100;
  all[kLidar].lowest_rad = -0.1, all[kLidar].highest_rad = 0.9;
  return all;
}

cv::Mat random_color(sensor_errors::Random& random) {
  cv::Mat channels[3], image;
  for (cv::Mat& channel : channels) channel = random_image({40, 32}, random);
  cv::merge(channels, 3, image);
  return image;
}

cv::Mat random_depth(sensor_errors::Random& random) {
  cv::Mat image(32, 40, CV_16UC1);
  for (auto& mm : cv::Mat_<std::uint16_t>(image)) mm = static_cast<std::uint16_t>(random.bits() % 60000);
  return image;
}

// Frames of 35 ms. The eye misses one; color and depth are at every second one, 1 ms before; sweeps of 20 ms
// before every third.
std::vector<slam::RigReading> rig_readings(int k, Stamp t, sensor_errors::Random& random) {
  std::vector<slam::RigReading> all;
  const auto add = [&](int sensor, Stamp at) -> slam::RigReading& {
    all.emplace_back().sensor = sensor;
    all.back().t = at;
    return all.back();
  };
  if (k != 5) add(kEye, t).image = random_image({64, 48}, random);
  if (k % 2 == 1) {
    add(kColor, t - Stamp(1'000'000)).image = random_color(random);
    add(kDepth, t - Stamp(1'000'000)).image = random_depth(random);
  }
  if (k % 3 == 1)
    for (slam::RigReading& sweep = add(kLidar, t - Stamp(20'000'000)); sweep.points.size() < 30;)
      sweep.points.push_back({float(random.normal()), float(random.normal()), float(random.normal()), 0.25f,
                              static_cast<std::int32_t>(600'000 * sweep.points.size())});
  for (Stamp end(10'000'000); end <= t; end += Stamp(10'000'000))
    if (end > t - Stamp(35'000'000)) add(kImu, end).begin = end - Stamp(10'000'000);
  for (slam::RigReading& reading : all)
    if (reading.sensor == kImu)
      reading.gyro = random_vector(random), reading.accelerometer = random_vector(random);
  return all;
}

class RigExport : public testing::Test {
 protected:
  RigExport() {
    sensor_errors::Random random(1, "rig export test");
    recording::RecordingSetup setup;
    setup.calibration = {head_camera(), random_pose(random)};
    setup.rig = sensors(random);
    X_GC_ = setup.calibration.X_CG.inverse();
    rig_ = setup.rig;
    recording::RecordingWriter writer(run_.result / "recording", setup);
    for (int k = 0; k < 12; ++k) {
      slam::Observation o;
      o.t = Stamp(35'000'000ll * k);
      for (Stamp end = o.t - Stamp(30'000'000); k > 0 && end <= o.t; end += Stamp(5'000'000))
        for (auto* readings : {&o.gyro, &o.accelerometer})
          readings->push_back({end - Stamp(5'000'000), end, random_vector(random)});
      o.image = random_image({64, 48}, random);
      o.rig = rig_readings(k, o.t, random);
      writer.add(o);
      X_WC_ = random_pose(random);
      writer.add(recording::TruePoses{o.t, X_WC_, random_pose(random), random_pose(random)});
      writer.add(recording::TrueMotion{o.t, random_pose(random), random_vector(random)});
      for (const slam::RigReading& reading : o.rig) readings_[reading.sensor].push_back(reading);
    }
    writer.finish();
    run_.errors = {};
  }

  fs::path made(const std::string& format) {
    const fs::path out = folder_ / format;
    export_run(run_, format, out, files::Existing::reject);
    return out;
  }

  json messages(const fs::path& mcap) {
    const fs::path modules = fs::path(GAITSLAM_SOURCE_DIR) / "build/interop",
                   output = folder_ / "messages.json";
    const std::string command =
        fmt::format("node '{}/tests/interop/dump_mcap.cjs' '{}' '{}' > '{}'", GAITSLAM_SOURCE_DIR,
                    modules.string(), mcap.string(), output.string());
    if (std::system(command.c_str()) != 0) throw std::runtime_error("node failed");
    return json::parse(files::read_text(output, 1 << 30));
  }

  static bool reader_missing() {
    return !fs::exists(fs::path(GAITSLAM_SOURCE_DIR) / "build/interop/node_modules/.installed") &&
           !std::getenv("CI");
  }

  files::TemporaryFolder folder_;
  ExportedRun run_{folder_ / "result", "a walk", 7, {}};
  std::vector<rig::RigSensor> rig_;
  std::map<int, std::vector<slam::RigReading>> readings_;
  Eigen::Isometry3d X_GC_, X_WC_;
};

std::string stamp(Stamp t) { return fmt::format("{}", recording::file_stamp(t)); }

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

cv::Mat bgr(const cv::Mat& rgb) {
  cv::Mat image;
  cv::cvtColor(rgb, image, cv::COLOR_RGB2BGR);
  return image;
}

std::vector<std::vector<std::string>> rows_of(const fs::path& file, char delimiter) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream in(files::read_text(file));
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("#")) continue;
    std::istringstream fields(line);
    rows.emplace_back();
    for (std::string field; std::getline(fields, field, delimiter);) rows.back().push_back(field);
  }
  return rows;
}

void expect_pose(const cv::FileNode& numbers, const Eigen::Isometry3d& X, double tolerance) {
  ASSERT_EQ(numbers.size(), 16u);
  for (int i = 0; i < 16; ++i) EXPECT_NEAR(numbers[i].real(), X(i / 4, i % 4), tolerance) << i;
}

void expect_rows(const cv::FileNode& rows, const Eigen::Isometry3d& X) {
  for (int i = 0; i < 16; ++i) EXPECT_NEAR(rows[i / 4][i % 4].real(), X(i / 4, i % 4), 1e-12) << i;
}

TEST_F(RigExport, EurocHasFurtherGrayEyesAndImusWithTheirMounting) {
  const fs::path mav0 = made("euroc") / "mav0";
  const auto& eye = readings_[kEye];
  const auto images = rows_of(mav0 / "cam1/data.csv", ',');
  ASSERT_EQ(images.size(), eye.size());
  for (std::size_t i = 0; i < eye.size(); ++i) {
    EXPECT_THAT(images[i], ElementsAre(stamp(eye[i].t), stamp(eye[i].t) + ".png"));
    EXPECT_TRUE(same(cv::imread(mav0 / "cam1/data" / images[i][1], cv::IMREAD_UNCHANGED), eye[i].image)) << i;
  }
  EXPECT_EQ(rows_of(mav0 / "../times.txt", ',').size(), 12u);
  EXPECT_EQ(rows_of(mav0 / "../times_stereo.txt", ',').size(), 11u);
  const auto& imu = readings_[kImu];
  const auto rows = rows_of(mav0 / "imu1/data.csv", ',');
  ASSERT_EQ(rows.size(), imu.size());
  for (std::size_t i = 0; i < imu.size(); ++i) {
    EXPECT_EQ(rows[i][0], stamp(imu[i].t - Stamp(5'000'000)));
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(std::stod(rows[i][static_cast<std::size_t>(1 + axis)]), imu[i].gyro[axis]);
      EXPECT_EQ(std::stod(rows[i][static_cast<std::size_t>(4 + axis)]), imu[i].accelerometer[axis]);
    }
  }
  const cv::FileStorage eye_yaml(mav0 / "cam1/sensor.yaml", cv::FileStorage::READ),
      imu_yaml(mav0 / "imu1/sensor.yaml", cv::FileStorage::READ);
  expect_pose(eye_yaml["T_BS"]["data"], X_GC_ * rig_[kEye].X_CS, 1e-12);
  EXPECT_EQ(eye_yaml["distortion_model"].string(), "equidistant");
  expect_pose(imu_yaml["T_BS"]["data"], X_GC_ * rig_[kImu].X_CS, 1e-12);
  EXPECT_EQ(imu_yaml["rate_hz"].real(), 100);
}

// The keys that ORB-SLAM3's Settings.cc requires for a stereo rig with IMU, by their types there.
TEST_F(RigExport, OrbSlam3StereoSettingsHaveTheKeysThatItsReaderRequires) {
  for (const bool undistort : {false, true}) {
    run_.undistort = undistort;
    export_run(run_, "orbslam3", folder_ / "o", files::Existing::replace);
    const cv::FileStorage settings(folder_ / "o/settings.yaml", cv::FileStorage::READ);
    std::vector<std::string> reals{
        "Stereo.ThDepth", "IMU.NoiseGyro",           "IMU.NoiseAcc", "IMU.GyroWalk", "IMU.AccWalk",
        "IMU.Frequency",  "ORBextractor.scaleFactor"},
        integers{"Camera.height",
                 "Camera.width",
                 "Camera.fps",
                 "Camera.RGB",
                 "ORBextractor.nFeatures",
                 "ORBextractor.nLevels",
                 "ORBextractor.iniThFAST",
                 "ORBextractor.minThFAST"};
    for (const char* camera : {"Camera1", "Camera2"}) {
      for (const char* key : {".fx", ".fy", ".cx", ".cy"}) reals.push_back(std::string(camera) + key);
      if (undistort) continue;
      for (const char* key : {".k1", ".k2", ".k3", ".k4"}) reals.push_back(std::string(camera) + key);
      for (const char* key : {".overlappingBegin", ".overlappingEnd"})
        integers.push_back(std::string(camera) + key);
    }
    EXPECT_EQ(settings["Camera.type"].string(), undistort ? "PinHole" : "KannalaBrandt8");
    for (const std::string& key : reals) EXPECT_TRUE(settings[key].isReal() || settings[key].isInt()) << key;
    for (const std::string& key : integers) EXPECT_TRUE(settings[key].isInt()) << key;
    EXPECT_EQ(settings["Camera1.fx"].real(), settings["Camera2.fx"].real());
    const cv::Mat T = settings["Stereo.T_c1_c2"].mat();
    ASSERT_EQ(T.type(), CV_32FC1);
    EXPECT_FLOAT_EQ(T.at<float>(0, 3), 0.06f) << "from the second camera to the first";
    EXPECT_FLOAT_EQ(T.at<float>(1, 1), 1);
    EXPECT_GE(rows_of(folder_ / "o/times_stereo.txt", ',').size(), 8u);
  }
}

TEST_F(RigExport, OpenVinsUsesBothEyesAndItsBagHasThem) {
  if (reader_missing()) GTEST_SKIP() << "tools/test.sh could not install the reader from npm";
  const fs::path out = made("openvins");
  const cv::FileStorage estimator(out / "estimator_config.yaml", cv::FileStorage::READ),
      cameras(out / "kalibr_imucam_chain.yaml", cv::FileStorage::READ),
      imus(out / "kalibr_imu_chain.yaml", cv::FileStorage::READ);
  EXPECT_EQ(static_cast<int>(estimator["max_cameras"]), 2);
  EXPECT_THAT(files::read_text(out / "estimator_config.yaml"), testing::HasSubstr("use_stereo: true\n"));
  expect_rows(cameras["cam1"]["T_imu_cam"], X_GC_ * rig_[kEye].X_CS);
  expect_rows(cameras["cam1"]["T_cn_cnm1"], rig_[kEye].X_CS.inverse());
  EXPECT_EQ(static_cast<int>(cameras["cam0"]["cam_overlaps"][0]), 1);
  EXPECT_EQ(static_cast<int>(cameras["cam1"]["cam_overlaps"][0]), 0);
  EXPECT_EQ(cameras["cam1"]["distortion_model"].string(), "equidistant");
  EXPECT_EQ(cameras["cam1"]["intrinsics"][3].real(), 25.4);
  EXPECT_EQ(static_cast<int>(cameras["cam1"]["resolution"][0]), 64);
  EXPECT_EQ(cameras["cam1"]["rostopic"].string(), "/cam1/image_raw");
  expect_rows(imus["imu1"]["T_i_b"], (X_GC_ * rig_[kImu].X_CS).inverse());
  json all = messages(out / "bag/run.mcap");
  EXPECT_EQ(all["/cam1/image_raw"].size(), 11u);
  EXPECT_EQ(all["/cam1/camera_info"].size(), 11u);
  EXPECT_EQ(all["/cam1/image_raw"][0]["encoding"], "mono8");
  EXPECT_EQ(all["/imu1"].size(), readings_[kImu].size());
  for (const auto& [topic, list] : all.items()) EXPECT_FALSE(topic.starts_with("/rig/")) << topic;
}

TEST_F(RigExport, TumHasColorDepthAndTheirPairs) {
  const fs::path out = made("tum");
  const auto& color = readings_[kColor];
  const auto& depth = readings_[kDepth];
  const auto images = rows_of(out / "rgb.txt", ' '), depths = rows_of(out / "depth.txt", ' '),
             pairs = rows_of(out / "associations.txt", ' ');
  ASSERT_EQ(images.size(), color.size());
  ASSERT_EQ(depths.size(), depth.size());
  ASSERT_EQ(pairs.size(), depth.size());
  for (std::size_t i = 0; i < color.size(); ++i) {
    EXPECT_TRUE(same(cv::imread(out / images[i][1], cv::IMREAD_UNCHANGED), bgr(color[i].image))) << i;
    EXPECT_TRUE(same(cv::imread(out / depths[i][1], cv::IMREAD_UNCHANGED), depth[i].image)) << i;
    EXPECT_THAT(pairs[i], ElementsAre(images[i][0], images[i][1], depths[i][0], depths[i][1]));
  }
  const cv::FileStorage settings(out / "settings.yaml", cv::FileStorage::READ);
  EXPECT_EQ(settings["RGBD.DepthMapFactor"].real(), 1000);
  EXPECT_EQ(settings["Stereo.b"].real(), 0.05);
  EXPECT_EQ(settings["Camera1.fx"].real(), 30);
  EXPECT_EQ(static_cast<int>(settings["Camera.RGB"]), 0) << "OpenCV reads BGR";
  const auto truth = rows_of(out / "groundtruth.txt", ' ');
  const Eigen::Isometry3d X_WS = X_WC_ * rig_[kColor].X_CS;
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(std::stod(truth.back()[static_cast<std::size_t>(1 + axis)]), X_WS.translation()[axis], 1e-12);
}

cv::Mat bytes(const json& hex, int rows, int columns, int type) {
  cv::Mat image(rows, columns, type);
  const std::string text = hex;
  if (text.size() != 2 * image.total() * image.elemSize()) return {};
  for (std::size_t i = 0; i < text.size() / 2; ++i)
    image.data[i] = static_cast<unsigned char>(std::stoi(text.substr(2 * i, 2), nullptr, 16));
  return image;
}

std::int64_t stamp_of(const json& message) {
  const json& t = message["header"]["stamp"];
  return t["sec"].get<std::int64_t>() * 1'000'000'000 + t["nanosec"].get<std::int64_t>();
}

TEST_F(RigExport, McapHasEachSensorAsItsReadersExpectIt) {
  if (reader_missing()) GTEST_SKIP() << "tools/test.sh could not install the reader from npm";
  json all = messages(made("mcap") / "run.mcap");
  const auto check = [&](int sensor, const std::string& topic, const char* frame, const auto& one) {
    const auto& expected = readings_[sensor];
    const json& list = all[topic];
    ASSERT_EQ(list.size(), expected.size()) << topic;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(list[i]["header"]["frame_id"], frame) << topic;
      one(list[i], expected[i]);
    }
  };
  const auto png = [](const json& message, const slam::RigReading& reading) {
    EXPECT_EQ(stamp_of(message), recording::file_stamp(reading.t));
    const cv::Mat row =
        bytes(message["data"], 1, static_cast<int>(message["data"].get<std::string>().size() / 2), CV_8UC1);
    const cv::Mat image = cv::imdecode(row, cv::IMREAD_UNCHANGED);
    EXPECT_TRUE(same(image, image.channels() == 3 ? bgr(reading.image) : reading.image));
  };
  check(kEye, "/rig/right_eye/image/compressed", "right_eye_optical_frame", png);
  check(kColor, "/rig/rgb0/image/compressed", "rgb0_optical_frame", png);
  check(kEye, "/rig/right_eye/camera_info", "right_eye_optical_frame",
        [&](const json& m, const auto& reading) {
          EXPECT_EQ(stamp_of(m), recording::file_stamp(reading.t));
          EXPECT_EQ(m["distortion_model"], "equidistant");
          EXPECT_NEAR(m["p"][3].get<double>(), -m["k"][0].get<double>() * 0.06, 1e-12);
        });
  check(kColor, "/rig/rgb0/camera_info", "rgb0_optical_frame", [](const json& m, const auto&) {
    EXPECT_EQ(m["distortion_model"], "plumb_bob");
    EXPECT_EQ(m["p"], json({30, 0, 19.5, 0, 0, 30, 15.5, 0, 0, 0, 1, 0}));
  });
  check(kDepth, "/rig/depth0/image_raw", "rgb0_optical_frame", [](const json& m, const auto& reading) {
    EXPECT_EQ(m["encoding"], "16UC1");
    EXPECT_EQ(m["step"], 80);
    EXPECT_TRUE(same(bytes(m["data"], 32, 40, CV_16UC1), reading.image));
  });
  check(kDepth, "/rig/depth0/camera_info", "rgb0_optical_frame", [](const json& m, const auto&) {
    EXPECT_EQ(m["k"], json({30, 0, 19.5, 0, 30, 15.5, 0, 0, 1}));
  });
  check(kLidar, "/rig/lidar0/points", "lidar0_frame", [](const json& m, const auto& sweep) {
    EXPECT_EQ(stamp_of(m), recording::file_stamp(sweep.t));
    const char* names[] = {"x", "y", "z", "intensity", "t"};
    for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(m["fields"][i]["name"], names[i]);
    ASSERT_EQ(m["points"].size(), sweep.points.size());
    for (std::size_t i = 0; i < sweep.points.size(); ++i) {
      const slam::LidarPoint& p = sweep.points[i];
      EXPECT_EQ(m["points"][i], json({p.x_m, p.y_m, p.z_m, p.intensity, p.offset_ns}));
    }
  });
  check(kImu, "/rig/chest/imu", "chest_frame", [](const json& m, const auto& imu) {
    EXPECT_EQ(stamp_of(m), recording::file_stamp(imu.t) - 5'000'000);
    EXPECT_EQ(m["angular_velocity"]["y"], imu.gyro.y());
    EXPECT_EQ(m["linear_acceleration"]["z"], imu.accelerometer.z());
  });
  const std::map<std::string, int> frames{{"right_eye_optical_frame", kEye},
                                          {"rgb0_optical_frame", kColor},
                                          {"lidar0_frame", kLidar},
                                          {"chest_frame", kImu}};
  ASSERT_EQ(all["/tf_static"].size(), 1u);
  const json& transforms = all["/tf_static"][0]["transforms"];
  EXPECT_EQ(transforms.size(), 1 + frames.size()) << "and the chest IMU's";
  for (const json& transform : transforms) {
    EXPECT_EQ(transform["header"]["frame_id"], "cam0_optical_frame");
    if (const auto frame = frames.find(transform["child_frame_id"]); frame != frames.end()) {
      EXPECT_EQ(transform["transform"]["translation"]["y"],
                rig_[static_cast<std::size_t>(frame->second)].X_CS.translation().y());
    }
  }
}

TEST_F(RigExport, TheUndistortedRightEyeIsThatOfAStereoPair) {
  if (reader_missing()) GTEST_SKIP() << "tools/test.sh could not install the reader from npm";
  run_.undistort = true;
  const json all = messages(made("mcap") / "run.mcap");
  const json &left = all["/camera/camera_info"][0], &right = all["/rig/right_eye/camera_info"][0];
  EXPECT_EQ(right["k"], left["k"]);
  EXPECT_EQ(left["p"][3], 0);
  EXPECT_NEAR(right["p"][3].get<double>(), -left["p"][0].get<double>() * 0.06, 1e-12);
}

TEST(Undistortion, ColorIsInterpolatedByChannelAndDepthTakenFromTheNearestPixel) {
  sensor_errors::Random random(1, "undistortion test");
  const Undistortion undistort(head_camera());
  cv::Mat channels[3], color;
  for (cv::Mat& channel : channels) channel = random_image({64, 48}, random);
  cv::merge(channels, 3, color);
  cv::Mat straight[3];
  cv::split(undistort(color), straight);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(same(straight[i], undistort(channels[i]))) << i;
  cv::Mat columns(48, 64, CV_16UC1);
  for (int i = 0; i < 64; ++i) columns.col(i) = 100 * i;
  const cv::Mat nearest = undistort(columns);
  const slam::Camera pinhole(undistort.pinhole()), recorded(head_camera());
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u) {
      const int mm = nearest.at<std::uint16_t>(v, u);
      EXPECT_EQ(mm % 100, 0);
      EXPECT_NEAR(mm / 100.0, recorded.project(pinhole.unproject({u, v})->h)->pixel.x(), 0.5 + 1e-9);
    }
}

// A wall 2 m away behind a board, seen from 0.1 m to the left with a longer focal length.
TEST(Registration, ADepthImageIsThatOfTheOtherCameraWithoutHolesAndWithTheNearestSurface) {
  const slam::CameraIntrinsics from{64, 48, 40, 40, 31.5, 23.5, slam::RadialTangential{}};
  const slam::CameraIntrinsics to{64, 48, 60, 60, 31.5, 23.5, slam::RadialTangential{}};
  cv::Mat depth(48, 64, CV_16UC1, cv::Scalar(2000));
  depth(cv::Rect(24, 20, 16, 8)) = 1000;
  const cv::Mat other = registered(depth, from, to, Eigen::Isometry3d(Eigen::Translation3d(0.1, 0, 0)));
  // The board's columns 23.5 to 39.5 are 25.5 to 49.5 there. The wall left of it ends at 22.5; right of it,
  // it starts at 46.5 and is covered.
  for (int u = 0; u < 64; ++u) {
    EXPECT_EQ(other.at<std::uint16_t>(23, u), u < 23 || u > 49 ? 2000 : u < 26 ? 0 : 1000) << u;
    EXPECT_EQ(other.at<std::uint16_t>(2, u), 2000) << u;
  }
}

}  // namespace
}  // namespace sim::exports
