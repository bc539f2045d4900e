#include "sim/score/landmarks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "tests/sim/score/square_camera.h"

namespace sim::score {
namespace {

using std::chrono::milliseconds;
using std::numbers::pi;

Eigen::Isometry3d turned(double angle) {
  return Eigen::Isometry3d(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
}

TEST(LoopClosure, MarksAreWhereAQuarterAndThreeQuartersAreTurned) {
  Trajectory plan;  // stands for 10 frames, then turns by 1° per frame, stands again
  for (int i = 0; i <= 400; ++i) plan.push_back({Stamp(i), turned(std::clamp(i - 10, 0, 360) * -pi / 180)});
  const auto marks = turn_marks(plan);
  ASSERT_TRUE(marks);
  EXPECT_NEAR(static_cast<double>(marks->quarter.count()), 100, 1);  // 90° exactly is a matter of rounding
  EXPECT_NEAR(static_cast<double>(marks->three_quarters.count()), 280, 1);
}

TEST(LoopClosure, APlanThatTurnsLessThanNearlyOnceHasNoMarks) {
  const auto plan = [](double degrees) {
    Trajectory t;
    for (int i = 0; i <= 100; ++i) t.push_back({Stamp(i), turned(degrees * i / 100 * pi / 180)});
    return t;
  };
  EXPECT_FALSE(turn_marks(plan(349)));
  EXPECT_TRUE(turn_marks(plan(351)));
  EXPECT_TRUE(turn_marks(plan(-351)));
  EXPECT_FALSE(turn_marks({}));
}

// A camera that turns once to the left in 40 s on the spot, in the middle of a room of 8 x 8 x 3 m, one frame
// each 0.1 s.
struct Circle {
  Circle() {
    for (int i = 0; i <= 400; ++i) truth.push_back({milliseconds(100 * i), looking(2 * pi * i / 400)});
    surfaces.push_back(box_room(4));
  }

  // Seen first in the image's middle at 1 s; matched again near the end at 39.9 s, `off` px from where truth
  // has it.
  LandmarkHistory landmark(double off) const {
    LandmarkHistory l;
    l.id = 7;
    l.first_seen = {milliseconds(1000), {160, 120}};
    l.accepted = {{milliseconds(1100), {160, 120}},
                  {milliseconds(39900), image_of_first_point(39900) + Eigen::Vector2d(off, 0)}};
    return l;
  }

  // The later pixel of the point on the wall ahead at 1 s (x = 4 m), from geometry.
  Eigen::Vector2d image_of_first_point(int t_ms) const {
    const double first = 2 * pi * 1000 / 40000, now = 2 * pi * t_ms / 40000;
    const Eigen::Vector3d p(4, 4 * std::tan(first), 1.4);
    return *camera.project(looking(now), p);
  }

  std::vector<int> found(const LandmarkHistory& l) const {
    std::vector<int> ids;
    for (const LoopLandmark& closing : loop_landmarks({l}, marks, truth, surfaces, camera))
      if (closing.closes) ids.push_back(closing.id);
    return ids;
  }

  Trajectory truth;
  std::vector<Surface> surfaces;
  TrueCamera camera = square_camera();
  TurnMarks marks{milliseconds(10000), milliseconds(30000)};
};

TEST(LoopClosure, ALandmarkLostFromViewAndFoundAgainWithinThreePixelsCounts) {
  const Circle circle;
  for (const double off : {0.0, 2.9, -2.9})
    EXPECT_EQ(circle.found(circle.landmark(off)), std::vector<int>{7}) << off;
  for (const double off : {4.0, -3.1}) EXPECT_TRUE(circle.found(circle.landmark(off)).empty()) << off;
}

TEST(LoopClosure, ALandmarkBegunAfterTheFirstQuarterDoesNotCount) {
  Circle circle;
  circle.marks.quarter = milliseconds(1000);
  EXPECT_TRUE(circle.found(circle.landmark(0)).empty());
  circle.marks.quarter = milliseconds(1100);
  EXPECT_FALSE(circle.found(circle.landmark(0)).empty());
}

TEST(LoopClosure, AMatchBeforeThreeQuartersIsFoundAgainButDoesNotClose) {
  Circle circle;
  circle.marks.three_quarters = milliseconds(40000);
  const auto again =
      loop_landmarks({circle.landmark(0)}, circle.marks, circle.truth, circle.surfaces, circle.camera);
  ASSERT_EQ(again.size(), 1u);
  EXPECT_EQ(again[0].found, milliseconds(39900));
  EXPECT_FALSE(again[0].closes);
}

TEST(LoopClosure, TheFirstMatchAfterTheLossCountsWhereverOnThePath) {
  Circle circle;
  circle.marks.three_quarters = milliseconds(39500);
  LandmarkHistory l = circle.landmark(0);
  l.accepted.insert(l.accepted.begin() + 1, {milliseconds(39000), circle.image_of_first_point(39000)});
  const auto again = loop_landmarks({l}, circle.marks, circle.truth, circle.surfaces, circle.camera);
  ASSERT_EQ(again.size(), 1u);
  EXPECT_EQ(again[0].found, milliseconds(39000));
  EXPECT_TRUE(again[0].closes);
}

TEST(LoopClosure, ALandmarkNeverMatchedAgainOrNeverOutOfViewOrOnNoSurfaceDoesNotCount) {
  Circle circle;
  LandmarkHistory l = circle.landmark(0);
  l.accepted.pop_back();
  EXPECT_TRUE(circle.found(l).empty());
  l = circle.landmark(0);
  circle.surfaces.clear();
  EXPECT_TRUE(circle.found(l).empty());
  circle = {};
  for (TimedPose& pose : circle.truth) pose.X = looking(0);
  l.accepted.back().pixel = {160, 120};
  EXPECT_TRUE(circle.found(l).empty());
}

TEST(LoopClosure, ALandmarkOutOfViewForLessThanFiveSecondsAtATimeDoesNotCount) {
  Circle circle;
  const auto look_away = [&](int from_ms, int to_ms) {
    for (TimedPose& pose : circle.truth)
      pose.X = looking(pose.t >= milliseconds(from_ms) && pose.t <= milliseconds(to_ms) ? pi : 0);
  };
  LandmarkHistory l = circle.landmark(0);
  l.accepted.back().pixel = {160, 120};
  look_away(20000, 24900);
  EXPECT_TRUE(circle.found(l).empty());
  look_away(20000, 25000);
  EXPECT_FALSE(circle.found(l).empty());
  look_away(20000, 28000);
  circle.truth[230].X = looking(0);  // seen for one frame in between: two stretches of 3 s and 4.9 s
  EXPECT_TRUE(circle.found(l).empty());
}

TEST(LoopClosure, TimeOutOfViewBeforeTheLandmarkWasBegunDoesNotCount) {
  Circle circle;
  for (TimedPose& pose : circle.truth) pose.X = looking(pose.t < milliseconds(9000) ? pi : 0);
  LandmarkHistory l = circle.landmark(0);
  l.first_seen.t = milliseconds(9500);
  l.accepted = {{milliseconds(39900), {160, 120}}};
  EXPECT_TRUE(circle.found(l).empty());
}

TEST(LoopClosure, AMatchOfTheRightPixelButAnotherSurfacePointDoesNotCount) {
  // A post stands between: the point first seen is on the post, not on the wall behind it.
  Circle circle;
  Surface post{Surface::Kind::cylinder, Eigen::Isometry3d::Identity(), {0.1, 1.5, 0}};
  const double first = 2 * pi * 1000 / 40000;
  post.X_WS.translation() = Eigen::Vector3d(std::cos(first), std::sin(first), 1.5);
  circle.surfaces.push_back(post);
  for (TimedPose& pose : circle.truth)
    if (pose.t > milliseconds(30000))
      pose.X.translation().y() += 0.2;  // walked aside: parallax separates the two
  LandmarkHistory l = circle.landmark(0);
  const Eigen::Vector3d on_wall(4, 4 * std::tan(first), 1.4),
      on_post = 0.9 * Eigen::Vector3d(std::cos(first), std::sin(first), 0) + Eigen::Vector3d(0, 0, 1.4);
  l.accepted.back().pixel = *circle.camera.project(circle.truth[399].X, on_wall);
  EXPECT_TRUE(circle.found(l).empty());
  l.accepted.back().pixel = *circle.camera.project(circle.truth[399].X, on_post);
  EXPECT_FALSE(circle.found(l).empty());
}

TEST(LoopClosure, EachLandmarkCountsOnceHoweverOftenItIsMatched) {
  const Circle circle;
  LandmarkHistory l = circle.landmark(0);
  l.accepted.clear();
  for (int t = 39000; t <= 39800; t += 100)
    l.accepted.push_back({milliseconds(t), circle.image_of_first_point(t)});
  const auto closing = loop_landmarks({l}, circle.marks, circle.truth, circle.surfaces, circle.camera);
  ASSERT_EQ(closing.size(), 1u);
  EXPECT_EQ(closing[0].found, milliseconds(39000));  // when it first does
}

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
  ASSERT_EQ(errors.size(), 1u);  // 2 was first seen at an unknown pose, 3 has no history
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
  const auto p_W = surface_point(histories[0].first_seen, truth, surfaces, square_camera());
  const Eigen::Vector3d off = 1.03 * (*p_W - truth[0].X.translation()) + truth[0].X.translation();
  const auto error = landmark_errors({{1, off, 1e-4 * Eigen::Matrix3d::Identity()}}, histories, truth,
                                     surfaces, square_camera(), 5);
  EXPECT_GT(error.at(0).nees.value(), 25);
  EXPECT_EQ(error.at(0).nees_of_template, error.at(0).nees);
}

}  // namespace
}  // namespace sim::score
