#include "sim/score/loop_closure.h"

#include <gtest/gtest.h>

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
    l.begun = {milliseconds(1000), {160, 120}};
    l.accepted = {{milliseconds(1100), {160, 120}},
                  {milliseconds(39900), image_of_first_point(39900) + Eigen::Vector2d(off, 0)}};
    return l;
  }

  // Where the point on the wall ahead at 1 s (x = 4 m) is at a later time, from geometry.
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

TEST(LoopClosure, ALandmarkLostFromViewAndFoundAgainCounts) {
  const Circle circle;
  EXPECT_EQ(circle.found(circle.landmark(0)), std::vector<int>{7});
  EXPECT_EQ(circle.found(circle.landmark(2.9)), std::vector<int>{7});
  EXPECT_EQ(circle.found(circle.landmark(-2.9)), std::vector<int>{7});
}

TEST(LoopClosure, FourPixelsOffDoesNotCount) {
  const Circle circle;
  EXPECT_TRUE(circle.found(circle.landmark(4)).empty());
  EXPECT_TRUE(circle.found(circle.landmark(-3.1)).empty());
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

TEST(LoopClosure, ALandmarkNeverMatchedAgainDoesNotCount) {
  const Circle circle;
  LandmarkHistory l = circle.landmark(0);
  l.accepted.pop_back();
  EXPECT_TRUE(circle.found(l).empty());
}

TEST(LoopClosure, ALandmarkThatIsNeverOutOfViewDoesNotCount) {
  Circle circle;
  for (StampedPose& pose : circle.truth) pose.X = looking(0);
  LandmarkHistory l = circle.landmark(0);
  l.accepted.back().pixel = {160, 120};
  EXPECT_TRUE(circle.found(l).empty());
}

TEST(LoopClosure, ALandmarkOutOfViewForLessThanFiveSecondsAtATimeDoesNotCount) {
  Circle circle;
  const auto look_away = [&](int from_ms, int to_ms) {
    for (StampedPose& pose : circle.truth)
      pose.X = looking(pose.t >= milliseconds(from_ms) && pose.t <= milliseconds(to_ms) ? pi : 0);
  };
  LandmarkHistory l = circle.landmark(0);
  l.accepted.back().pixel = {160, 120};
  look_away(20000, 24900);
  EXPECT_TRUE(circle.found(l).empty());
  look_away(20000, 25000);
  EXPECT_FALSE(circle.found(l).empty());
  look_away(20000, 28000);
  circle.truth[230].X =
      looking(0);  // one frame in between in which it is seen: two stretches of 3 s and 4.9 s
  EXPECT_TRUE(circle.found(l).empty());
}

TEST(LoopClosure, TimeOutOfViewBeforeTheLandmarkWasBegunDoesNotCount) {
  Circle circle;
  for (StampedPose& pose : circle.truth) pose.X = looking(pose.t < milliseconds(9000) ? pi : 0);
  LandmarkHistory l = circle.landmark(0);
  l.begun.t = milliseconds(9500);
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
  for (StampedPose& pose : circle.truth)
    if (pose.t > milliseconds(30000))
      pose.X.translation().y() += 0.2;  // walked aside: parallax tells the two apart
  LandmarkHistory l = circle.landmark(0);
  const Eigen::Vector3d on_wall(4, 4 * std::tan(first), 1.4),
      on_post = 0.9 * Eigen::Vector3d(std::cos(first), std::sin(first), 0) + Eigen::Vector3d(0, 0, 1.4);
  l.accepted.back().pixel = *circle.camera.project(circle.truth[399].X, on_wall);
  EXPECT_TRUE(circle.found(l).empty());
  l.accepted.back().pixel = *circle.camera.project(circle.truth[399].X, on_post);
  EXPECT_FALSE(circle.found(l).empty());
}

TEST(LoopClosure, ALandmarkOnNoSurfaceDoesNotCount) {
  Circle circle;
  circle.surfaces.clear();
  EXPECT_TRUE(circle.found(circle.landmark(0)).empty());
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

}  // namespace
}  // namespace sim::score
