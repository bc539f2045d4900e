
#include "sim/score/run.h"
#include "sim/score/types.h"
#include "tests/sim/score/score_fixtures.h"

namespace sim::score {
namespace {

using Kind = Surface::Kind;
using Eigen::Vector3d, std::chrono::milliseconds, std::numbers::pi;

// By hand: shapes at the origin, rays along axes. RoomSurfaces compares rays in rooms with MuJoCo's.
TEST(Surfaces, TheNearestHitIsWhereGeometryHasIt) {
  const Vector3d x = Vector3d::UnitX(), z = Vector3d::UnitZ();
  const auto hit = [](Kind kind, const Vector3d& size, const Vector3d& origin, const Vector3d& direction) {
    return first_hit({{kind, Eigen::Isometry3d::Identity(), size}}, origin, direction);
  };
  EXPECT_EQ(hit(Kind::box, {1, 2, 3}, {-5, 0, 0}, x), 4);
  EXPECT_EQ(hit(Kind::box, {1, 2, 3}, {0, 0, 0}, x), 1);  // from inside: the wall ahead
  EXPECT_EQ(hit(Kind::box, {1, 2, 3}, {-5, 2.1, 0}, x), std::nullopt);
  EXPECT_EQ(hit(Kind::box, {1, 2, 3}, {5, 0, 0}, x), std::nullopt);  // behind
  EXPECT_NEAR(*hit(Kind::sphere, {1, 0, 0}, {-5, 0, 0.6}, x), 4.2, 1e-14);
  EXPECT_EQ(hit(Kind::ellipsoid, {1, 2, 3}, {0, 0, 5}, -z), 2);
  EXPECT_NEAR(*hit(Kind::ellipsoid, {1, 2, 3}, {-5, 1.2, 0}, x), 4.2, 1e-14);  // 0.6 of its half axis aside
  EXPECT_EQ(hit(Kind::cylinder, {1, 2, 0}, {0.5, 0.5, 5}, -z), 3);
  EXPECT_NEAR(*hit(Kind::capsule, {1, 2, 0}, {-5, 0, 2.6}, x), 4.2, 1e-14);  // 0.6 up the cap: 0.8 wide
  EXPECT_EQ(hit(Kind::plane, {0, 0, 1}, {100, 100, 5}, -z), 5);
  EXPECT_EQ(hit(Kind::plane, {0, 0, 1}, {0, 0, -5}, z), std::nullopt);  // from below it is not seen
  EXPECT_EQ(hit(Kind::plane, {1, 2, 1}, {0.9, 1.9, 5}, -z), 5);
  EXPECT_EQ(hit(Kind::plane, {1, 2, 1}, {1.1, 0, 5}, -z), std::nullopt);
  const Surface near{Kind::box, upright(5, 0, 0), {1, 1, 1}}, far{Kind::box, upright(10, 0, 0), {1, 1, 1}};
  EXPECT_EQ(first_hit({far, near}, Vector3d::Zero(), x), 4);
  EXPECT_EQ(first_hit({far}, Vector3d::Zero(), x), 9);
  EXPECT_EQ(first_hit({far, near}, Vector3d::Zero(), Vector3d::UnitY()), std::nullopt);
}

TEST(LoopClosure, MarksAreWhereAQuarterAndThreeQuartersOfNearlyOneTurnAreDone) {
  Trajectory plan;  // stands for 10 frames, then turns by 1° per frame, stands again
  for (int i = 0; i <= 400; ++i)
    plan.push_back({Stamp(i), upright(0, 0, 0, std::clamp(i - 10, 0, 360) * -kDegree)});
  const auto marks = turn_marks(plan);
  ASSERT_TRUE(marks);
  EXPECT_NEAR(static_cast<double>(marks->quarter.count()), 100, 1);  // 90° exactly is a matter of rounding
  EXPECT_NEAR(static_cast<double>(marks->three_quarters.count()), 280, 1);
  for (const double degrees : {349, 351, -351}) {
    plan.clear();
    for (int i = 0; i <= 100; ++i) plan.push_back({Stamp(i), upright(0, 0, 0, degrees * i / 100 * kDegree)});
    EXPECT_EQ(turn_marks(plan).has_value(), std::abs(degrees) > 350) << degrees;
  }
  EXPECT_FALSE(turn_marks({}));
}

// A camera that turns once to the left in 40 s on the spot, in the middle of a room of 8 x 8 x 3 m, one frame
// each 0.1 s. The landmark is seen first in the image's middle at 1 s, and again near the end at 39.9 s.
struct Circle {
  Circle() {
    for (int i = 0; i <= 400; ++i)
      run.truth_camera.push_back({milliseconds(100 * i), looking(2 * pi * i / 400)});
    run.surfaces = {box_room(4)};
    run.camera = square_camera();
    run.landmarks = {{7,
                      {milliseconds(1000), kMiddle},
                      {{milliseconds(1100), kMiddle}, {milliseconds(39900), image_of_first_point(39900)}}}};
  }

  LandmarkHistory& landmark() { return run.landmarks.front(); }
  // The later pixel of the point on the wall ahead at 1 s (x = 4 m), from geometry.
  Eigen::Vector2d image_of_first_point(int t_ms) const {
    return *run.camera.project(looking(2 * pi * t_ms / 40000), {4, 4 * std::tan(kFirst), 1.4});
  }
  // Looks ahead but for some time to the back; the last match is then in the middle.
  void look_back(int from_ms, int to_ms) {
    for (TimedPose& pose : run.truth_camera)
      pose.X = looking(pose.t >= milliseconds(from_ms) && pose.t <= milliseconds(to_ms) ? pi : 0);
    landmark().accepted.back().pixel = kMiddle;
  }
  std::vector<LoopLandmark> found() const { return loop_landmarks(run, marks); }
  bool closes() const { return !found().empty() && found().front().closes; }

  static inline const Eigen::Vector2d kMiddle{160, 120};
  static constexpr double kFirst = 2 * pi * 1000 / 40000;
  Run run;
  TurnMarks marks{milliseconds(10000), milliseconds(30000)};
};

TEST(LoopClosure, ALandmarkOfTheFirstQuarterLostFromViewAndFoundAgainWithinThreePixelsCounts) {
  for (const double off : {0.0, 2.9, -2.9, 4.0, -3.1}) {
    Circle circle;
    circle.landmark().accepted.back().pixel.x() += off;
    EXPECT_EQ(circle.closes(), std::abs(off) < 3) << off;
  }
  Circle later, unmatched, without_room, in_view;
  later.marks.quarter = milliseconds(1000);
  unmatched.landmark().accepted.pop_back();
  without_room.run.surfaces.clear();
  in_view.look_back(50000, 50000);
  for (const Circle& circle : {later, unmatched, without_room, in_view}) EXPECT_TRUE(circle.found().empty());
  later.marks.quarter = milliseconds(1100);
  EXPECT_TRUE(later.closes());
}

TEST(LoopClosure, TheFirstMatchAfterTheLossCountsWhereverOnThePath) {
  Circle circle;
  circle.marks.three_quarters = milliseconds(40000);
  ASSERT_EQ(circle.found().size(), 1u);
  EXPECT_FALSE(circle.closes()) << "no match after three quarters";
  circle.marks.three_quarters = milliseconds(39500);
  for (int t = 39800; t >= 39000; t -= 100)
    circle.landmark().accepted.insert(circle.landmark().accepted.begin() + 1,
                                      {milliseconds(t), circle.image_of_first_point(t)});
  ASSERT_EQ(circle.found().size(), 1u) << "once, however often it is matched";
  EXPECT_EQ(circle.found()[0].found, milliseconds(39000));
  EXPECT_TRUE(circle.closes());
}

TEST(LoopClosure, ALandmarkOutOfViewForLessThanFiveSecondsAtATimeDoesNotCount) {
  Circle circle;
  circle.look_back(20000, 24900);
  EXPECT_FALSE(circle.closes());
  circle.look_back(20000, 25000);
  EXPECT_TRUE(circle.closes());
  circle.look_back(20000, 28000);
  circle.run.truth_camera[230].X =
      looking(0);  // seen for one frame in between: two stretches of 3 s and 4.9 s
  EXPECT_FALSE(circle.closes());
  circle.look_back(0, 8900);
  circle.landmark().first_seen.t = milliseconds(9500);  // time before that does not count
  EXPECT_FALSE(circle.closes());
}

TEST(LoopClosure, AMatchOfTheRightPixelButAnotherSurfacePointDoesNotCount) {
  // A post stands between: the point first seen is on the post, not on the wall behind it.
  Circle circle;
  const Eigen::Vector3d ahead(std::cos(Circle::kFirst), std::sin(Circle::kFirst), 0), eye(0, 0, 1.4);
  circle.run.surfaces.push_back({Surface::Kind::cylinder, upright(ahead.x(), ahead.y(), 1.5), {0.1, 1.5, 0}});
  for (TimedPose& pose : circle.run.truth_camera)
    if (pose.t > milliseconds(30000))
      pose.X.translation().y() += 0.2;  // walked aside: parallax separates the two
  const auto closes_at = [&](const Eigen::Vector3d& p_W) {
    circle.landmark().accepted.back().pixel = *circle.run.camera.project(circle.run.truth_camera[399].X, p_W);
    return circle.closes();
  };
  EXPECT_FALSE(closes_at({4, 4 * std::tan(Circle::kFirst), 1.4}));
  EXPECT_TRUE(closes_at(0.9 * ahead + eye));
}

class LandmarkAccuracy : public testing::Test {
 protected:
  LandmarkAccuracy() {
    run_.truth_camera = {{Stamp(0), looking(0)}, {Stamp(1), looking(1)}};
    run_.surfaces = {box_room(4)};
    run_.camera = square_camera();
  }
  std::vector<LandmarkError> errors(const std::vector<MappedPoint>& map, int half_px = 0) {
    run_.map = map;
    return landmark_errors(run_, half_px);
  }
  // Of one landmark, first seen at that pixel.
  LandmarkError error(const Eigen::Vector2d& pixel, const Eigen::Vector3d& p_W, int half_px) {
    run_.landmarks = {{1, {Stamp(0), pixel}, {}}};
    return errors({{1, p_W, 1e-4 * Eigen::Matrix3d::Identity()}}, half_px).at(0);
  }
  score::Run run_;
};

TEST_F(LandmarkAccuracy, IsTheDistanceToTheSurfacePointFirstSeen) {
  // The pixel (80, 120) looks 26.6° to the left: at the wall x = 4 m the point (4, 2, 1.4).
  run_.landmarks = {{1, {Stamp(0), {80, 120}}, {}}, {2, {Stamp(7), {80, 120}}, {}}};
  const Eigen::Vector3d p(4.03, 2, 1.36);
  const Eigen::Matrix3d P = Eigen::Vector3d(0.01, 1, 0.04).cwiseAbs2().asDiagonal();
  const auto found = errors({{1, p, P}, {2, p, P}, {3, p, P}});
  ASSERT_EQ(found.size(), 1u);  // 2 was first seen at an unknown pose, 3 has no history
  EXPECT_EQ(found[0].id, 1);
  EXPECT_NEAR(found[0].distance, 0.05, 1e-12);
  EXPECT_NEAR(found[0].nees.value(), 9 + 1, 1e-9);
  EXPECT_FALSE(errors({{1, p, Eigen::Matrix3d::Zero()}}).at(0).nees);
  run_.surfaces.clear();
  EXPECT_TRUE(errors({{1, p, P}}).empty());  // no surface, no truth
}

// The first pixel is three pixels beside a pillar 2 m away that stands before a wall 4 m away.
TEST_F(LandmarkAccuracy, OfATemplateAcrossAnEdgeIsTheErrorAgainstEitherSurfaceButNotBetweenThem) {
  run_.surfaces.push_back(
      {Surface::Kind::box, upright(2.1, -0.5, 1.5), {0.1, 0.5, 1.5}});  // from y = 0, pixel 160
  const auto at = [&](double x_m, int half_px) {
    return error({157, 120}, {x_m, x_m * 3.0 / 160, 1.4}, half_px);
  };
  EXPECT_LT(at(4, 5).nees.value(), 1e-9);
  EXPECT_LT(at(4, 5).nees_of_template.value(), 1e-9);
  EXPECT_GT(at(2, 5).nees.value(), 1000);
  EXPECT_LT(at(2, 5).nees_of_template.value(), 0.1);
  EXPECT_GT(at(2, 2).nees_of_template.value(), 1000) << "the template does not reach the pillar";
  EXPECT_GT(at(3, 5).nees_of_template.value(), 1000);
  EXPECT_EQ(at(3, 0).nees_of_template, at(3, 0).nees);
  run_.surfaces.pop_back();
  // A floor seen at a slant has many distances within a template, and is one surface.
  const LandmarkError off = error({160, 235}, {1.03 * 1.4 * 160 / 115, 0, 1.4 - 1.03 * 1.4}, 5);
  EXPECT_GT(off.nees.value(), 25);
  EXPECT_EQ(off.nees_of_template, off.nees);
}

}  // namespace
}  // namespace sim::score
