// Exports of a rig, read back by OpenCV and by npm's readers.
#include <nlohmann/json.hpp>
#include <opencv2/core/persistence.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "slam/camera.h"
#include "tests/sim/export/exported.h"

namespace sim::exports {
namespace {

using nlohmann::json, testing::ElementsAre, tests::expect_same;

struct RigExport : Exported {
  RigExport() : Exported(true) {}
};

std::string stamp(Stamp t) { return fmt::format("{}", recording::file_stamp(t)); }

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

// numbers: 16 of them, or four rows.
void expect_pose(const cv::FileNode& numbers, const Eigen::Isometry3d& X) {
  for (int i = 0; i < 16; ++i)
    EXPECT_NEAR((numbers.size() == 4 ? numbers[i / 4][i % 4] : numbers[i]).real(), X(i / 4, i % 4), 1e-12);
}

// The poses of a single-precision matrix.
void expect_pose(const cv::Mat& T, const Eigen::Isometry3d& X) {
  ASSERT_EQ(T.type(), CV_32FC1);
  for (int i = 0; i < 16; ++i) EXPECT_NEAR(T.at<float>(i), X(i / 4, i % 4), 1e-6);
}

double density(double sigma) { return sigma * std::sqrt(0.005); }  // of a 5 ms reading

TEST_F(RigExport, EurocHasFurtherGrayEyesAndImusWithTheirMounting) {
  const fs::path mav0 = made("euroc") / "mav0";
  const auto& eye = readings_[kEye];
  const auto images = rows_of(mav0 / "cam1/data.csv", ',');
  ASSERT_EQ(images.size(), eye.size());
  for (std::size_t i = 0; i < eye.size(); ++i) {
    EXPECT_THAT(images[i], ElementsAre(stamp(eye[i].t), stamp(eye[i].t) + ".png"));
    expect_same(cv::imread(mav0 / "cam1/data" / images[i][1], cv::IMREAD_UNCHANGED), eye[i].image);
  }
  EXPECT_EQ(rows_of(mav0 / "../times.txt", ',').size(), 10u);
  EXPECT_EQ(rows_of(mav0 / "../times_stereo.txt", ',').size(), 7u);
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
  expect_pose(eye_yaml["T_BS"]["data"], X_GC_ * rig_[kEye].X_CS);
  EXPECT_EQ(eye_yaml["distortion_model"].string(), "equidistant");
  expect_pose(imu_yaml["T_BS"]["data"], X_GC_ * rig_[kImu].X_CS);
  EXPECT_EQ(imu_yaml["rate_hz"].real(), 100);
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
    EXPECT_GE(rows_of(folder_ / "orbslam3/times_stereo.txt", ',').size(), 5u);
  }
}

TEST_F(RigExport, OpenVinsUsesBothEyesAndItsBagHasThem) {
  const fs::path out = made("openvins");
  const cv::FileStorage estimator(out / "estimator_config.yaml", cv::FileStorage::READ),
      cameras(out / "kalibr_imucam_chain.yaml", cv::FileStorage::READ),
      imus(out / "kalibr_imu_chain.yaml", cv::FileStorage::READ);
  EXPECT_EQ(static_cast<int>(estimator["max_cameras"]), 2);
  EXPECT_THAT(files::read_text(out / "estimator_config.yaml"), testing::HasSubstr("use_stereo: true\n"));
  EXPECT_EQ(estimator["relative_config_imu"].string(), "kalibr_imu_chain.yaml");
  EXPECT_EQ(estimator["track_frequency"].real(), 31) << "above the rate of the camera";
  EXPECT_DOUBLE_EQ(imus["imu0"]["gyroscope_noise_density"].real(), density(0.01));
  EXPECT_EQ(imus["imu0"]["rostopic"].string(), "/imu0");
  expect_pose(cameras["cam0"]["T_imu_cam"], X_GC_);
  expect_pose(cameras["cam1"]["T_imu_cam"], X_GC_ * rig_[kEye].X_CS);
  expect_pose(cameras["cam1"]["T_cn_cnm1"], rig_[kEye].X_CS.inverse());
  EXPECT_EQ(static_cast<int>(cameras["cam0"]["cam_overlaps"][0]), 1);
  EXPECT_EQ(static_cast<int>(cameras["cam1"]["cam_overlaps"][0]), 0);
  EXPECT_EQ(cameras["cam1"]["distortion_model"].string(), "equidistant");
  EXPECT_EQ(cameras["cam1"]["intrinsics"][3].real(), 25.4);
  EXPECT_EQ(static_cast<int>(cameras["cam1"]["resolution"][0]), 64);
  EXPECT_EQ(cameras["cam1"]["rostopic"].string(), "/cam1/image_raw");
  expect_pose(imus["imu1"]["T_i_b"], (X_GC_ * rig_[kImu].X_CS).inverse());
  if (!reader_missing().empty()) GTEST_SKIP() << reader_missing();
  json all = json::parse(messages(out / "bag/run.mcap"));
  EXPECT_EQ(all["/cam1/image_raw"].size(), readings_[kEye].size());
  EXPECT_EQ(all["/cam1/camera_info"].size(), readings_[kEye].size());
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
    expect_same(cv::imread(out / images[i][1], cv::IMREAD_UNCHANGED), bgr(color[i].image));
    expect_same(cv::imread(out / depths[i][1], cv::IMREAD_UNCHANGED), depth[i].image);
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
  if (!reader_missing().empty()) GTEST_SKIP() << reader_missing();
  json all = json::parse(messages(made("mcap") / "run.mcap"));
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
    expect_same(image, image.channels() == 3 ? bgr(reading.image) : reading.image);
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
    EXPECT_EQ(m["p"], json({30, 0, 31.5, 0, 0, 30, 23.5, 0, 0, 0, 1, 0}));
  });
  check(kDepth, "/rig/depth0/image_raw", "rgb0_optical_frame", [](const json& m, const auto& reading) {
    EXPECT_EQ(m["encoding"], "16UC1");
    EXPECT_EQ(m["step"], 128);
    expect_same(bytes(m["data"], 48, 64, CV_16UC1), reading.image);
  });
  check(kDepth, "/rig/depth0/camera_info", "rgb0_optical_frame", [](const json& m, const auto&) {
    EXPECT_EQ(m["k"], json({30, 0, 31.5, 0, 30, 23.5, 0, 0, 1}));
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
  if (!reader_missing().empty()) GTEST_SKIP() << reader_missing();
  run_.undistort = true;
  const json all = json::parse(messages(made("mcap") / "run.mcap"));
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
  for (int i = 0; i < 3; ++i) expect_same(straight[i], undistort(channels[i]));
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
