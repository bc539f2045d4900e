#include "sim/export/export.h"
#include "sim/view/session.h"
#include "tests/sim/scenario/test_scenarios.h"

namespace sim::view {
namespace {

// Sensors on three links, the head camera tilted.
constexpr const char* kMounts = R"(
walk: {commands: [stand: {duration_s: 0.5}]}
camera: {tilt_deg: 20, position_m: [0.1, 0, 0.05]}
imu: {link: BODY, position_m: [0, 0.1, 0.1]}
rig: [gray: {}, lidar: {link: CHEST_LINK0, position_m: [-0.2, 0, 0.3], tilt_deg: 30}, imu: {link: HEAD_LINK0}]
)";

// The mounting is the head camera's pose in the link of a sensor, so that each leads to the same camera.
TEST(RobotDescription, NamesTheLinkOfEachSensorAndWhereTheHeadCameraIsRelativeToIt) {
  const auto robot = robot_description(scenario::read_text(kMounts).scenario, GAITSLAM_SOURCE_DIR "/models");
  const std::vector<Eigen::Isometry3d> poses = robot->poses(Eigen::VectorXd::Zero(30));
  const std::map<std::string, std::string> links{{"cam0", "HEAD_LINK1"},
                                                 {"imu0", "waist"},
                                                 {"cam1", "HEAD_LINK1"},
                                                 {"lidar0", "CHEST_LINK0"},
                                                 {"imu1", "HEAD_LINK0"}};
  ASSERT_EQ(robot->mountings.size(), links.size());
  std::optional<Eigen::Isometry3d> X_BC;
  for (const auto& [sensor, mounting] : robot->mountings) {
    EXPECT_EQ(mounting.link, links.at(sensor));
    const auto link = std::ranges::find(robot->links, mounting.link) - robot->links.begin();
    const Eigen::Isometry3d X_BL =
        mounting.link == "waist" ? Eigen::Isometry3d::Identity() : poses.at(static_cast<std::size_t>(link));
    if (!X_BC) X_BC = X_BL * mounting.X_LC;
    EXPECT_TRUE((X_BL * mounting.X_LC).isApprox(*X_BC, 1e-9)) << sensor;
  }
  EXPECT_NEAR(X_BC->linear()(2, 2), -std::sin(20 * std::numbers::pi / 180), 1e-9) << "looks down";
}

}  // namespace
}  // namespace sim::view
