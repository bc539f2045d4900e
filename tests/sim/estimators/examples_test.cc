// The example programs on a walk through a synthetic room.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "sim/tracking/tracking.h"
#include "tests/slam/synthetic_room.h"

namespace sim::estimators {
namespace {

using tracking::Tracked;
using tracking::Tracking;

/// A quarter of a circle that is walked as planned, with images.
const slam::synthetic::Recording& walk() {
  static const slam::synthetic::Recording recording = [] {
    slam::synthetic::Walk walk;
    walk.turns = 0.25, walk.duration_s = 4, walk.slip = walk.yaw_error = 0;
    return slam::synthetic::Recording(walk, slam::synthetic::render(slam::synthetic::Room(), walk));
  }();
  return recording;
}

/// An observation with the planned velocity since the previous frame, which the synthetic room leaves at 0.
slam::Observation observation(int frame) {
  slam::Observation o = walk().observation(frame);
  if (frame == 0) return o;
  const Eigen::Isometry3d before = walk().observation(frame - 1).plan->X_PC;
  const double rate_hz = walk().walk().rate_hz;
  const Eigen::Isometry3d moved = before.inverse() * o.plan->X_PC;
  const Eigen::AngleAxisd turned(moved.linear());
  o.plan->v_PC_C = moved.linear().transpose() * moved.translation() * rate_hz;
  o.plan->w_PC_C = turned.angle() * turned.axis() * rate_hz;
  return o;
}

Tracked track(const std::string& estimator, const std::vector<std::string>& more = {}) {
  constexpr const char* kText =
      "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\nseed: 5\n";
  std::vector<std::string> overrides{"estimator=" + estimator};
  overrides.insert(overrides.end(), more.begin(), more.end());
  Tracking tracking(scenario::read_scenario_text(kText, "test.yaml", {overrides, {}}).scenario,
                    slam::synthetic::calibration(), walk().walk().X_WC(0));
  for (int frame = 0; frame < walk().walk().frames(); ++frame) tracking.step(observation(frame));
  return tracking.finish();
}

double distance_at_end(const Tracked& tracked) {
  const PoseEstimate last = tracked.estimates().back();
  return (last.X_WC.translation() - walk().walk().X_WC(slam::seconds(last.t)).translation()).norm();
}

void expect_same(const Tracked& a, const Tracked& b) {
  ASSERT_FALSE(a.failed) << *a.failed;
  ASSERT_FALSE(b.failed) << *b.failed;
  const auto p = a.estimates(), q = b.estimates();
  ASSERT_EQ(p.size(), q.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    EXPECT_EQ(p[i].t, q[i].t);
    EXPECT_EQ(p[i].X_WC.matrix(), q[i].X_WC.matrix()) << i;  // bit for bit
    EXPECT_EQ(p[i].covariance, q[i].covariance) << i;
    EXPECT_EQ(a.frames[i].report.health, b.frames[i].report.health);
  }
}

TEST(Examples, TheFilterAsAProgramGivesTheBitsOfTheBuiltInFilter) {
  const Tracked built_in = track("filter", {"slam.gyro.sigma_rad_s=0.02"});
  const std::string options = "options: {gyro: {sigma_rad_s: 0.02}}";
  expect_same(built_in, track(fmt::format("{{program: \"{}\", {}}}", GAITSLAM_FILTER_PROGRAM, options)));
  const Tracked other = track(fmt::format("{{program: \"{}\"}}", GAITSLAM_FILTER_PROGRAM));
  EXPECT_NE(other.estimates().back().X_WC.matrix(), built_in.estimates().back().X_WC.matrix());
}

TEST(Examples, GyroAndPlanFollowTheWalk) {
  const Tracked program = track(fmt::format("{{program: \"{}\"}}", GAITSLAM_GYRO_PROGRAM));
  ASSERT_FALSE(program.failed) << *program.failed;
  EXPECT_LT(distance_at_end(program), 0.05);  // of 1.2 m walked; the sway, which no plan has, is 0.03
  EXPECT_FALSE(program.estimates().back().covariance);
  const Tracked wrong =
      track(fmt::format("{{program: \"{}\", options: {{bais: 0}}}}", GAITSLAM_GYRO_PROGRAM));
  ASSERT_TRUE(wrong.failed);
  EXPECT_NE(wrong.failed->find("unknown option, expected bias=0 or bias=1"), std::string::npos)
      << *wrong.failed;
}

TEST(Examples, GyroAndPlanInPythonIsTheSameEstimatorToRounding) {
  const Tracked c = track(fmt::format("{{program: \"{}\"}}", GAITSLAM_GYRO_PROGRAM)),
                python = track(
                    fmt::format("{{program: [/usr/bin/python3, \"{}/tools/examples/gyro_and_plan.py\"]}}",
                                GAITSLAM_SOURCE_DIR));
  ASSERT_FALSE(python.failed) << *python.failed;
  ASSERT_EQ(python.estimates().size(), c.estimates().size());
  EXPECT_TRUE(python.estimates().back().X_WC.isApprox(c.estimates().back().X_WC, 1e-9));
}

}  // namespace
}  // namespace sim::estimators
