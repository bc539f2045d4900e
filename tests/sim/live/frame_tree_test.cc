#include "sim/export/ros_bag.h"
#include "sim/view/session.h"
#include "tests/sim/live/run_folder.h"

namespace {

namespace fs = std::filesystem;

using FrameTree = tests::RunFolder;

// Sensors on three links, the head camera tilted.
constexpr const char* kMounts = R"(
walk: {commands: [stand: {duration_s: 0.5}]}
camera: {width_px: 64, height_px: 48, tilt_deg: 20, position_m: [0.1, 0, 0.05]}
imu: {link: BODY, position_m: [0, 0.1, 0.1]}
rig: [gray: {}, lidar: {link: CHEST_LINK0, position_m: [-0.2, 0, 0.3], tilt_deg: 30}, imu: {link: HEAD_LINK0}]
)";

TEST_F(FrameTree, ReachesEachSensorWhereItIsMounted) {
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
