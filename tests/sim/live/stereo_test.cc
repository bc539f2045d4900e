#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "sim/export/ros_bag.h"
#include "sim/view/session.h"
#include "tests/sim/live/run_folder.h"

namespace {

namespace fs = std::filesystem;

using StereoExport = tests::RunFolder;

// The second eye is rotated, so that the pictures must be rectified.
constexpr const char* kStand = R"(
walk: {commands: [stand: {duration_s: 0.1}]}
camera: {width_px: 640, height_px: 480}
rig: [gray: {baseline_m: 0.12, yaw_deg: 2, tilt_deg: 1, read_sigma_gray: 0, shot_sigma_gray: 0}, depth: {}]
errors: {image: {read_sigma_gray: 0, shot_sigma_gray: 0}}
)";

// Textured pixels have a horizontal gradient of at least 8 gray levels per pixel.
TEST_F(StereoExport, OpenCvsMatcherMeasuresTheDepthOfTheOfficeAndRevealsAWrongBaseline) {
  run("run", read(kStand));
  const auto e = folder_ / "e";
  sim::exports::export_run({folder_ / "run", "stereo", 1, {}}, "openvins", e);
  const std::string file = "data/1000000000000000000.png", names[] = {"cam0", "cam1"};
  const cv::Mat true_mm = cv::imread(folder_ / "run/recording/mav0/depth0" / file, cv::IMREAD_UNCHANGED);
  const cv::FileStorage chain(e / "kalibr_imucam_chain.yaml", cv::FileStorage::READ);
  cv::Mat K[2], images[2], straight[2], us[2], vs[2], R[2], P[2], Q, no, disparity, points, depth, gradient;
  std::vector<double> k[2];
  for (int i = 0; i < 2; ++i) {
    const cv::FileNode f = chain[names[i]]["intrinsics"];
    K[i] = (cv::Mat_<double>(3, 3) << f[0].real(), 0, f[2].real(), 0, f[1].real(), f[3].real(), 0, 0, 1);
    chain[names[i]]["distortion_coeffs"] >> k[i];
    images[i] = cv::imread(e / "mav0" / names[i] / file, cv::IMREAD_GRAYSCALE);
  }
  cv::Matx44d T;  // from the left camera to the right one
  for (int i = 0; i < 16; ++i) T.val[i] = chain["cam1"]["T_cn_cnm1"][i / 4][i % 4].real();
  for (const double baseline_factor : {1.0, 1.05}) {
    cv::stereoRectify(K[0], no, K[1], no, true_mm.size(), T.get_minor<3, 3>(0, 0),
                      baseline_factor * T.get_minor<3, 1>(0, 3), R[0], R[1], P[0], P[1], Q);
    for (int i = 0; i < 2; ++i) {
      cv::fisheye::initUndistortRectifyMap(K[i], k[i], R[i], P[i], true_mm.size(), CV_32F, us[i], vs[i]);
      cv::remap(images[i], straight[i], us[i], vs[i], cv::INTER_LINEAR);
    }
    cv::StereoSGBM::create(0, 128, 5, 200, 800, 1, 0, 10, 100, 2)
        ->compute(straight[0], straight[1], disparity);
    disparity.convertTo(disparity, CV_32F, 1 / 16.0);
    cv::reprojectImageTo3D(disparity, points, Q);
    cv::remap(true_mm, depth, us[0], vs[0], cv::INTER_NEAREST);
    cv::Sobel(straight[0], gradient, CV_32F, 1, 0, 3, 1 / 8.0);
    const cv::Mat textured = (cv::abs(gradient) >= 8) & (depth > 0), answered = textured & (disparity > 0);
    std::vector<double> errors;
    for (int v = 0; v < depth.rows; ++v)
      for (int u = 0; u < depth.cols; ++u)
        if (answered.at<uchar>(v, u)) {
          const cv::Vec3d p = cv::Matx33d(R[0]).t() * cv::Vec3d(points.at<cv::Vec3f>(v, u));
          errors.push_back(std::abs(1e3 * p[2] / depth.at<ushort>(v, u) - 1));
        }
    std::ranges::sort(errors);
    ASSERT_GT(errors.size(), 1000u);
    const double share = double(errors.size()) / cv::countNonZero(textured),
                 median = errors[errors.size() / 2];
    EXPECT_EQ(median < 0.02, baseline_factor == 1)
        << share << " of the pixels: " << median << ", 90 %: " << errors[errors.size() * 9 / 10];
  }
}

// Sensors on three links, the head camera tilted.
constexpr const char* kMounts = R"(
walk: {commands: [stand: {duration_s: 0.5}]}
camera: {width_px: 64, height_px: 48, tilt_deg: 20, position_m: [0.1, 0, 0.05]}
imu: {link: BODY, position_m: [0, 0.1, 0.1]}
rig: [gray: {}, lidar: {link: CHEST_LINK0, position_m: [-0.2, 0, 0.3], tilt_deg: 30}, imu: {link: HEAD_LINK0}]
)";

TEST_F(StereoExport, TheRobotsFrameTreeReachesEachSensorWhereItIsMounted) {
  const fs::path root = GAITSLAM_SOURCE_DIR;
  if (!fs::exists(root / "build/interop/node_modules/.installed") && !std::getenv("CI"))
    GTEST_SKIP() << "tools/test.sh could not install the reader from npm";
  const auto scenario = read(kMounts);
  run("run", scenario);
  const auto e = folder_ / "e";
  sim::exports::ExportedRun mounts{folder_ / "run", "mounts", 1, {}};
  mounts.robot = sim::view::robot_description(scenario.scenario, kModels);
  sim::exports::export_run(mounts, "mcap", e);
  const auto setup = sim::recording::RecordingReader(folder_ / "run/recording").setup();
  nlohmann::json sensors;
  const auto add = [&](const std::string& frame, const Eigen::Matrix4d& X) {
    const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> rows = X;
    sensors[frame] = std::vector<double>(rows.data(), rows.data() + 16);
  };
  add("imu", setup.calibration.X_CG.matrix());
  for (const sim::rig::RigSensor& sensor : setup.rig)
    add(sim::exports::frame_of(sensor), sensor.X_CS.matrix());
  sim::files::write_text(e / "sensors.json", sensors.dump());
  const std::string tests = (root / "tests/interop").string(), mcap = (e / "run.mcap").string();
  const std::string command = fmt::format(
      "node '{0}/dump_mcap.cjs' '{1}/build/interop' '{2}' > '{3}/messages.json' && "
      "/usr/bin/python3 '{0}/read_exports.py' mounting '{3}' '{3}/sensors.json'",
      tests, root.string(), mcap, e.string());
  EXPECT_EQ(std::system(command.c_str()), 0);
}

}  // namespace
