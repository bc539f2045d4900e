#include "sim/live/steering_pose_buffer.h"

#include <atomic>

#include "sim/live/frame_pipeline.h"

namespace sim::live {
namespace {

using namespace std::chrono_literals;

constexpr double kDegree = std::numbers::pi / 180;

Eigen::Isometry3d pose(double x, double y, double z, double yaw, double pitch = 0) {
  return Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY());
}

/// A camera 1.3 m above the ground; its support sole is 0.1 m behind and to the left of it.
slam::PlannedMotion planned(double yaw = 0.4) {
  slam::PlannedMotion motion;
  motion.X_PC = pose(1, 2, 1.3, yaw);
  motion.p_CF = {-0.1, 0.1, -1.3};
  return motion;
}

walking::SteeringOptions late(double latency_s) {
  walking::SteeringOptions options;
  options.latency_s = latency_s;
  return options;
}

slam::Estimate estimate(slam::Stamp t, const Eigen::Isometry3d& X_WC) {
  return {t, X_WC, slam::Matrix6d::Identity() * 1e-6};
}

TEST(PlaceEstimate, IsThePlannedSoleAsTheEstimatedCameraSeesIt) {
  const Eigen::Isometry3d X_WP = pose(0.2, -0.1, 0, 5 * kDegree);
  const walking::PlaceEstimate place = place_estimate(estimate(1s, X_WP * planned().X_PC), planned());
  const Eigen::Vector3d sole = planned().X_PC * planned().p_CF;
  EXPECT_EQ(place.t_s, 1);
  EXPECT_LT((place.planned.position - sole.head<2>()).norm(), 1e-12);
  EXPECT_LT((place.estimated.position - (X_WP * sole).head<2>()).norm(), 1e-12);
  EXPECT_NEAR(place.estimated.yaw - place.planned.yaw, 5 * kDegree, 1e-12);
}

TEST(PlaceEstimate, ABodyThatTiltsAboutItsFootDoesNotMoveTheFoot) {
  const Eigen::Vector3d foot = planned().X_PC * planned().p_CF;
  const Eigen::Isometry3d tilt = Eigen::Translation3d(foot) *
                                 Eigen::AngleAxisd(0.03, Eigen::Vector3d(1, 2, 0).normalized()) *
                                 Eigen::Translation3d(-foot);
  const walking::PlaceEstimate place = place_estimate(estimate(1s, tilt * planned().X_PC), planned());
  EXPECT_LT((place.estimated.position - place.planned.position).norm(), 1e-12);
  EXPECT_NEAR(place.estimated.yaw, 0, 1e-3);
}

/// Compares with central differences: the covariance of a place that depends on only one part of the pose
/// error.
TEST(PlaceEstimate, CovarianceMatchesThePoseError) {
  const slam::Estimate believed = estimate(1s, pose(0.3, 0.1, 1.3, 0.7, 0.2));
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    slam::Estimate one = believed;
    one.covariance.setZero();
    one.covariance(i, i) = 1;
    const auto moved = [&](double by) {
      slam::Estimate e = believed;
      if (i < 3)
        e.X_WC.rotate(Eigen::AngleAxisd(by, Eigen::Vector3d::Unit(i)));
      else
        e.X_WC.translation()(i - 3) += by;
      return place_estimate(e, planned()).estimated;
    };
    const walking::FootPose after = moved(kStep), before = moved(-kStep);
    Eigen::Vector3d J;
    J << (after.position - before.position) / (2 * kStep), (after.yaw - before.yaw) / (2 * kStep);
    const Eigen::Matrix3d expected = J * J.transpose();
    const Eigen::Matrix3d found = place_estimate(one, planned()).covariance;
    // The heading is taken from the rotation about z nearest to a tilted one: equal to first order in the
    // tilt.
    EXPECT_LT((found - expected).topLeftCorner(2, 2).norm(), 1e-6) << i;
    EXPECT_NEAR(found(2, 2), expected(2, 2), 0.1) << i;
  }
}

TEST(SteeringPoseBuffer, UsesEstimatesOnlyOnceTheyAreOldEnough) {
  SteeringPoseBuffer places(late(0.1), {}, 0ms);
  for (const slam::Stamp t : {slam::Stamp(0ms), slam::Stamp(33ms), slam::Stamp(67ms)}) {
    places.add(t, planned());
    places.add(t, estimate(t, planned().X_PC), true);
  }
  EXPECT_EQ(places.usable_until(150ms), slam::Stamp(50ms));
  EXPECT_FALSE(places.newest(-1ms));
  EXPECT_EQ(places.newest(66ms)->t_s, 0.033);
  EXPECT_EQ(places.newest(67ms)->t_s, 0.067);
  const SteeringPoseBuffer exposed(late(0.01), {}, 30ms);  // waits for the end of the exposure
  EXPECT_EQ(exposed.usable_until(100ms), slam::Stamp(70ms));
}

TEST(SteeringPoseBuffer, LeavesOutLostEstimates) {
  SteeringPoseBuffer places(late(0), {sensor_errors::EstimateLost{{0.05, 0.1}}}, 0ms);
  for (int k = 0; k < 6; ++k) {
    const slam::Stamp t = k * 33ms;
    places.add(t, planned());
    places.add(t, estimate(t, planned().X_PC), k != 5);
  }
  EXPECT_EQ(places.newest(100ms)->t_s, 0.033);
  EXPECT_EQ(places.newest(165ms)->t_s, 0.033);  // the fault ends at 0.15 s, but the last frame does not track
}

TEST(SteeringPoseBuffer, FaultsDisplaceAndFreezeEstimates) {
  SteeringPoseBuffer jumped(late(0), {sensor_errors::EstimateJump{{0.03, 1}, 0.3, 0, 10 * kDegree}}, 0ms);
  SteeringPoseBuffer frozen(late(0), {sensor_errors::EstimateFrozen{{0.03, 1}}}, 0ms);
  for (int k = 0; k < 3; ++k) {
    const slam::Stamp t = k * 33ms;
    slam::PlannedMotion motion = planned();
    motion.X_PC.translation().x() += 0.01 * k;
    for (SteeringPoseBuffer* places : {&jumped, &frozen}) {
      places->add(t, motion);
      places->add(t, estimate(t, motion.X_PC), true);
    }
  }
  EXPECT_NEAR(jumped.newest(0ms)->estimated.yaw, 0, 1e-12);
  EXPECT_NEAR(jumped.newest(66ms)->estimated.yaw, 10 * kDegree, 1e-12);
  const auto stuck = frozen.newest(66ms);
  EXPECT_EQ(stuck->t_s, 0.066);
  EXPECT_NEAR(stuck->estimated.position.x() - stuck->planned.position.x(), -0.02, 1e-12);
}

TEST(OrderedWorker, WorksInOrderOnOneThreadAndPassesOnResultsAndExceptions) {
  for (const bool beside : {false, true}) {
    std::vector<int> done;
    std::set<std::thread::id> threads;
    OrderedWorker worker(beside);
    for (int i = 0; i < 5; ++i)
      worker.do_next([&, i] { return done.push_back(i), threads.insert(std::this_thread::get_id()), 0; });
    auto fault = worker.do_next([]() -> int { throw std::runtime_error("no"); });
    EXPECT_EQ(worker.do_next([] { return 8; }).get(), 8);
    EXPECT_THROW(fault.get(), std::runtime_error);
    EXPECT_EQ(done, (std::vector{0, 1, 2, 3, 4}));
    EXPECT_EQ(threads.size(), 1u);
    EXPECT_EQ(threads.contains(std::this_thread::get_id()), !beside);
  }
}

TEST(OrderedWorker, DropsWorkThatHasNotBegunWhenItEnds) {
  std::promise<void> begun, go_on;
  std::atomic<bool> second = false;
  std::jthread later;
  {
    OrderedWorker worker(true);
    worker.do_next([&] { begun.set_value(), go_on.get_future().wait(); });
    begun.get_future().wait();
    worker.do_next([&] { second = true; });
    later = std::jthread([&] { std::this_thread::sleep_for(20ms), go_on.set_value(); });
  }
  EXPECT_FALSE(second);
}

}  // namespace
}  // namespace sim::live
