// The example programs on a walk along a circle.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "sim/tracking/tracking.h"

namespace sim::estimators {
namespace {

using tracking::Tracked;

constexpr double kSpeed_m_s = 0.3, kTurn_rad_s = 0.4, kWalked_s = 4;
constexpr std::chrono::milliseconds kFrame(20), kRest(500);

const Eigen::Matrix3d kR_CG =
    Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();

/// At rest, then ahead (z) and to the right (about y, down). The gyro has a bias, the plan has none.
slam::Observation observation(int frame) {
  slam::Observation o;
  o.t = frame * kFrame;
  o.plan.emplace();
  const bool walks = o.t > kRest;
  if (walks) o.plan->v_PC_C.z() = kSpeed_m_s, o.plan->w_PC_C.y() = kTurn_rad_s;
  if (frame > 0)
    o.gyro.push_back(
        {o.t - kFrame, o.t, kR_CG.transpose() * o.plan->w_PC_C + Eigen::Vector3d(0.01, -0.02, 0.03)});
  return o;
}

Tracked track(const std::string& estimator) {
  const std::string text = "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\n";
  slam::Calibration calibration;
  calibration.X_CG.linear() = kR_CG;
  tracking::Tracking tracking(
      scenario::read_scenario_text(text, "test.yaml", {{"estimator=" + estimator}, {}}).scenario, calibration,
      Eigen::Isometry3d::Identity());
  for (int frame = 0; frame * kFrame <= kRest + std::chrono::duration<double>(kWalked_s); ++frame)
    tracking.step(observation(frame));
  return tracking.finish();
}

std::string gyro_program(const std::string& more = "") {
  return fmt::format("{{program: \"{}\"{}}}", GAITSLAM_GYRO_PROGRAM, more);
}

TEST(Examples, GyroAndPlanFollowTheWalkInCAndPythonAlike) {
  const Tracked c = track(gyro_program()),
                python = track(
                    fmt::format("{{program: [/usr/bin/python3, \"{}/tools/examples/gyro_and_plan.py\"]}}",
                                GAITSLAM_SOURCE_DIR));
  ASSERT_FALSE(c.failed) << *c.failed;
  ASSERT_FALSE(python.failed) << *python.failed;
  const double angle = kTurn_rad_s * kWalked_s, radius = kSpeed_m_s / kTurn_rad_s;
  const Eigen::Vector3d end(radius * (1 - std::cos(angle)), 0, radius * std::sin(angle));
  const PoseEstimate last = c.estimates().back();
  EXPECT_LT((last.X_WC.translation() - end).norm(), 0.01);  // half a frame at the start is half as fast
  EXPECT_FALSE(last.covariance);
  ASSERT_EQ(python.estimates().size(), c.estimates().size());
  EXPECT_TRUE(python.estimates().back().X_WC.isApprox(last.X_WC, 1e-9));
}

TEST(Examples, AWrongOptionIsReportedByTheProgram) {
  const Tracked wrong = track(gyro_program(", options: {bais: 0}"));
  ASSERT_TRUE(wrong.failed);
  EXPECT_THAT(*wrong.failed, testing::HasSubstr("unknown option, expected bias=0 or bias=1"));
}

}  // namespace
}  // namespace sim::estimators
