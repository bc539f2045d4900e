#include "sim/score/landmark_accuracy.h"

#include <gtest/gtest.h>

#include "tests/sim/score/square_camera.h"

namespace sim::score {
namespace {

TEST(LandmarkAccuracy, IsTheDistanceToTheSurfacePointFirstSeen) {
  const Surface room = box_room(4);
  const Trajectory truth{{Stamp(0), looking(0)}, {Stamp(1), looking(1)}};
  // The pixel (80, 120) looks 26.6° to the left: at the wall x = 4 m the point (4, 2, 1.4).
  const std::vector<LandmarkHistory> histories{{1, {Stamp(0), {80, 120}}, {}},
                                               {2, {Stamp(7), {80, 120}}, {}}};
  const Eigen::Vector3d p(4.03, 2, 1.36);
  Eigen::Matrix3d P = Eigen::Vector3d(0.01, 1, 0.04).cwiseAbs2().asDiagonal();
  const auto errors =
      landmark_errors({{1, p, P}, {2, p, P}, {3, p, P}}, histories, truth, {room}, square_camera());
  ASSERT_EQ(errors.size(), 1u);  // 2 was begun at no known pose, 3 has no history
  EXPECT_EQ(errors[0].id, 1);
  EXPECT_NEAR(errors[0].distance, 0.05, 1e-12);
  EXPECT_NEAR(errors[0].nees.value(), 9 + 1, 1e-9);
  const auto unsure =
      landmark_errors({{1, p, Eigen::Matrix3d::Zero()}}, histories, truth, {room}, square_camera());
  EXPECT_FALSE(unsure.at(0).nees);
  EXPECT_TRUE(
      landmark_errors({{1, p, P}}, histories, truth, {}, square_camera()).empty());  // no surface, no truth
}

}  // namespace
}  // namespace sim::score
