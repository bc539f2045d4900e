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

// The first pixel is three pixels beside a pillar 2 m away that stands before a wall 4 m away.
TEST(LandmarkAccuracy, OfATemplateAcrossAnEdgeIsTheErrorAgainstEitherSurfaceButNotBetweenThem) {
  Surface pillar{Surface::Kind::box, Eigen::Isometry3d::Identity(), {0.1, 0.5, 1.5}};
  pillar.X_WS.translation() << 2.1, -0.5, 1.5;  // its left edge is at y = 0, pixel 160
  const std::vector<Surface> surfaces{box_room(4), pillar};
  const Trajectory truth{{Stamp(0), looking(0)}};
  const std::vector<LandmarkHistory> histories{{1, {Stamp(0), {157, 120}}, {}}};
  const Eigen::Vector3d ray(1, 3.0 / 160, 0);
  const Eigen::Matrix3d P = 1e-4 * Eigen::Matrix3d::Identity();
  const auto error = [&](double x_m, int half_px) {
    const Eigen::Vector3d p_W = Eigen::Vector3d(0, 0, 1.4) + x_m * ray;
    return landmark_errors({{1, p_W, P}}, histories, truth, surfaces, square_camera(), half_px).at(0);
  };
  EXPECT_LT(error(4, 5).nees.value(), 1e-9);
  EXPECT_LT(error(4, 5).nees_of_template.value(), 1e-9);
  EXPECT_GT(error(2, 5).nees.value(), 1000);
  EXPECT_LT(error(2, 5).nees_of_template.value(), 0.1);
  EXPECT_GT(error(2, 2).nees_of_template.value(), 1000) << "the template does not reach the pillar";
  EXPECT_GT(error(3, 5).nees_of_template.value(), 1000);
  EXPECT_EQ(error(3, 0).nees_of_template, error(3, 0).nees);
}

// A floor seen at a slant has many distances within a template, and is one surface.
TEST(LandmarkAccuracy, OfATemplateOnOneSlantedSurfaceIsTheErrorAtTheFirstPixel) {
  const std::vector<Surface> surfaces{box_room(4)};
  const Trajectory truth{{Stamp(0), looking(0)}};
  const std::vector<LandmarkHistory> histories{{1, {Stamp(0), {160, 235}}, {}}};
  const auto p_W = surface_point(histories[0].begun, truth, surfaces, square_camera());
  const Eigen::Vector3d off = 1.03 * (*p_W - truth[0].X.translation()) + truth[0].X.translation();
  const auto error = landmark_errors({{1, off, 1e-4 * Eigen::Matrix3d::Identity()}}, histories, truth,
                                     surfaces, square_camera(), 5);
  EXPECT_GT(error.at(0).nees.value(), 25);
  EXPECT_EQ(error.at(0).nees_of_template, error.at(0).nees);
}

}  // namespace
}  // namespace sim::score
