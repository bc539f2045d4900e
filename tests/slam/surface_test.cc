#include "slam/vision/active_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "slam/vision/corner_detector.h"
#include "tests/slam/synthetic_room.h"

namespace slam {
namespace {

/// A camera 1.4 m above the floor, turned by `heading` to the left of +x.
Eigen::Isometry3d level(double x, double y, double heading) {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.translation() = Eigen::Vector3d(x, y, 1.4);
  X_WC.linear().col(2) = Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
  X_WC.linear().col(1) = -Eigen::Vector3d::UnitZ();
  X_WC.linear().col(0) = X_WC.linear().col(1).cross(X_WC.linear().col(2));
  return X_WC;
}

State state(const Eigen::Isometry3d& X_WC, const Eigen::Vector3d& p_W) {
  State s;
  s.size = kRobot + Point::kSize;
  s.storage_x = Eigen::VectorXd::Zero(s.size);
  s.storage_x.segment<3>(kPosition) = X_WC.translation();
  const Eigen::Quaterniond q(X_WC.linear());
  s.storage_x.segment<4>(kOrientation) << q.w(), q.x(), q.y(), q.z();
  s.storage_x.tail<3>() = p_W;
  return s;
}

/// The strongest corner of a box of the first picture, its place known, and looks at it from elsewhere.
struct Sight {
  Sight(const Eigen::Isometry3d& X_WC_first, const cv::Rect& box) {
    const cv::Mat image = room.render(camera, X_WC_first, 2);
    const auto corner = strongest_corner(image, box, 1000).value();
    landmark.kind = Point{};
    landmark.at = kRobot;
    landmark.patch = cut_patch(image, corner.pixel);
    landmark.X_WC_first = X_WC_first;
    const Eigen::Vector3d ray = X_WC_first.linear() * camera.unproject(corner.pixel.cast<double>())->h;
    p_W = room.hit(X_WC_first.translation(), ray);
  }
  void look(const Eigen::Isometry3d& X_WC, int times) {
    const cv::Mat image = room.render(camera, X_WC, 2);
    const Eigen::Vector2d pixel = camera.project(X_WC.inverse() * p_W)->pixel;
    for (int i = 0; i < times; ++i)
      landmark.tilt = refined_tilt(image, landmark, pixel, camera, state(X_WC, p_W));
  }
  Eigen::Vector3d normal() const { return surface_normal(landmark.X_WC_first, p_W, landmark.tilt); }

  synthetic::Room room;
  Camera camera{CameraIntrinsics{}};
  Landmark landmark;
  Eigen::Vector3d p_W;
};

double degrees_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(a.dot(b)) * 180 / std::numbers::pi;
}

TEST(Surface, TheNormalOfAWallFirstSeenObliquelyIsEstimatedFromOtherViews) {
  Sight sight(level(1.0, 1.2, 0.0), cv::Rect(215, 40, 85, 70));
  ASSERT_NEAR(sight.p_W.x(), 3.6, 1e-3);  // on the wall ahead, to the right
  const Eigen::Vector3d wall(-1, 0, 0);
  const double before = degrees_between(sight.normal(), wall);
  ASSERT_GT(before, 25);
  for (const double aside : {0.4, 0.8, 1.2}) sight.look(level(1.0, 1.2 - aside, 0.0), 8);
  EXPECT_LT(degrees_between(sight.normal(), wall), before / 3);  // not 0: the prior prefers small tilts
}

TEST(Surface, ARightNormalAndOneWhoseViewHasNotChangedStay) {
  Sight facing(level(1.0, 1.2, 0.0), cv::Rect(140, 100, 40, 40));
  ASSERT_NEAR(facing.p_W.x(), 3.6, 1e-3);
  for (const double aside : {0.4, 0.8, 1.2}) facing.look(level(1.0, 1.2 - aside, 0.0), 8);
  EXPECT_LT(degrees_between(facing.normal(), {-1, 0, 0}), 10);
  Sight askew(level(1.0, 1.2, 0.0), cv::Rect(215, 40, 85, 70));
  askew.look(level(1.0, 1.2, 0.0), 8);
  EXPECT_EQ(askew.landmark.tilt, Eigen::Vector2d(0, 0));
}

}  // namespace
}  // namespace slam
