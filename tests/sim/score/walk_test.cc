// The drift of the walk by its feet, navigation, and landmarks against the true room.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/score/run.h"
#include "sim/score/types.h"
#include "tests/sim/score/score_fixtures.h"

namespace sim::score {
namespace {

using namespace std::chrono_literals;
using Kind = Surface::Kind;
using Eigen::Vector3d, std::chrono::milliseconds, std::numbers::pi;

// A walk in place of one sample per 10 ms; feet at y = ±0.1 and 10 samples to a support.
class Walk {
 public:
  Walk() {
    left().truth = left().plan = {0, 0.1, 0};
    right().truth = right().plan = {0, -0.1, 0};
    both();
  }
  TrueFoot& left() { return now_.left; }
  TrueFoot& right() { return now_.right; }

  void both(int count = 3) { stay(count, 0.5, 0.5); }
  void on_left(int count = 10) { stay(count, 1, 0); }
  void on_right(int count = 10) { stay(count, 0, 1); }
  void stay(int count, double left_load, double right_load) {
    for (int i = 0; i < count; ++i) {
      now_.t += std::chrono::milliseconds(10);
      left().load_n = left_load, left().planned_down = left_load > 0;
      right().load_n = right_load, right().planned_down = right_load > 0;
      samples.push_back(now_);
    }
  }
  std::vector<FootRow> rows(const Eigen::Vector3d& waist_truth = Eigen::Vector3d::Zero(),
                            const Eigen::Vector3d& waist_plan = Eigen::Vector3d::Zero()) const {
    return decompose_drift(samples, 1, waist_truth, waist_plan);
  }
  std::vector<TrueFeet> samples;

 private:
  TrueFeet now_;
};

struct Total {
  int rows = 0;
  double moved = 0, turned = 0, creep = 0;
  Eigen::Vector3d drift = Eigen::Vector3d::Zero();
};
Total total(const std::vector<FootRow>& rows, std::optional<FootPhase> phase = {}) {
  Total sum;
  for (const FootRow& row : rows) {
    if (phase && row.phase != *phase) continue;
    ++sum.rows;
    sum.moved += row.moved.head<2>().norm();
    sum.turned += std::abs(row.moved.z());
    sum.creep += row.creep.head<2>().norm();
    sum.drift += row.drift;
  }
  return sum;
}

TEST(Feet, APlanCarriedOutExactlyHasNoDrift) {
  Walk walk;
  walk.on_left();
  walk.both();
  walk.on_right();
  walk.both();
  const auto rows = walk.rows({1, 2, 0.3}, {1, 2, 0.3});
  EXPECT_FALSE(rows.empty());
  for (const FootRow& row : rows) {
    EXPECT_NEAR(row.drift.norm(), 0, 1e-15);
    EXPECT_EQ(row.moved.norm(), 0);
  }
}

TEST(Feet, ATurnOfTheStandingFootSwingsTheRestOfTheWayAboutIt) {
  Walk walk;
  walk.on_left(5);
  walk.left().truth.z() += 0.01;
  walk.right().truth = {-0.01 * -0.2, -0.1, 0.01};  // the swing foot goes with the body
  walk.on_left(5);
  walk.both();
  const auto rows = walk.rows({1, 0.11, 0.01}, {1, 0.1, 0});
  const Total support = total(rows, FootPhase::support);
  EXPECT_NEAR(support.turned, 0.01, 1e-12);
  EXPECT_NEAR(support.drift.z(), 0.01, 1e-12);
  EXPECT_NEAR(support.drift.y(), std::sin(0.01), 1e-12);  // 1 m ahead of the foot
  EXPECT_NEAR(total(rows, FootPhase::put_down).drift.y(), 0, 1e-4);
}

TEST(Feet, AFootPutDownBesideItsPlaceIsALandingErrorAndNoSlip) {
  Walk walk;
  walk.on_left();
  walk.right().plan = {0.2, -0.1, 0};
  walk.right().truth = {0.207, -0.098, 0.005};
  walk.both();
  walk.on_right();
  const auto rows = walk.rows({0.2, 0, 0}, {0.2, 0, 0});
  const Total put_down = total(rows, FootPhase::put_down);
  EXPECT_EQ(put_down.rows, 1);
  EXPECT_NEAR(put_down.moved, std::hypot(0.007, 0.002), 1e-12);
  EXPECT_NEAR(put_down.drift.z(), 0.005, 1e-12);
  EXPECT_EQ(total(rows, FootPhase::landing).moved, 0);
  EXPECT_EQ(total(rows, FootPhase::support).moved, 0);
}

TEST(Feet, AFootThatDragsAfterTheOtherHasLandedHasNoShareInTheDrift) {
  Walk walk;
  walk.on_left();
  walk.stay(2, 0.9, 0.1);  // the right one lands
  walk.stay(2, 0.3, 0.7);  // the left one lifts off
  walk.left().truth.x() += 0.004;
  walk.stay(2, 0.1, 0.9);
  walk.on_right();
  const auto rows = walk.rows();
  EXPECT_NEAR(total(rows, FootPhase::lift_off).moved, 0.004, 1e-12);
  EXPECT_EQ(total(rows, FootPhase::lift_off).drift.x(), 0);
  EXPECT_EQ(total(rows).drift.x(), 0);
}

TEST(Feet, AFootSlidingAsItLandsIsToldFromOneThatSlidesUnderLoad) {
  Walk walk;
  walk.on_left();
  walk.stay(3, 0.9, 0.1);
  walk.right().truth.x() += 0.002;
  walk.right().creep.x() = 0.0005;  // in each of the samples to come
  walk.stay(1, 0.3, 0.7);
  walk.right().truth.x() += 0.003;
  walk.on_right(4);
  const auto rows = walk.rows({0.005, 0, 0});
  const Total landing = total(rows, FootPhase::landing), support = total(rows, FootPhase::support);
  EXPECT_NEAR(landing.moved, 0.002, 1e-12);
  EXPECT_NEAR(support.moved, 0.003, 1e-12);
  EXPECT_NEAR(landing.creep, 0.0005, 1e-12);
  EXPECT_NEAR(support.creep, 0.002, 1e-12);
  EXPECT_NEAR(support.drift.x(), 0.003, 1e-12);
}

TEST(Feet, AllSharesAddUpToTheDriftOfTheWaist) {
  Walk walk;
  for (int i = 0; i < 12; ++i) {
    walk.both();
    const bool left = i % 2 == 0;
    TrueFoot &swing = left ? walk.right() : walk.left(), &stand = left ? walk.left() : walk.right();
    stand.truth.z() += 0.003 * i;
    walk.stay(10, left, !left);
    stand.truth.x() -= 0.001;
    swing.plan.x() += 0.15;
    swing.plan.z() += 0.1;
    swing.truth = {swing.plan.x() + 0.01 * i, swing.plan.y() - 0.02, swing.plan.z() + 0.03};
    walk.stay(2, left, !left);
    if (i != 5) continue;
    walk.both(40);  // a rest; after it the foot that has landed lifts again
    ++i;
  }
  walk.both();
  const Eigen::Vector3d drift = total(walk.rows({1.1, 0.2, 0.9}, {1.0, 0.3, 0.7})).drift;
  EXPECT_NEAR(drift.x(), 0.1, 1e-9);
  EXPECT_NEAR(drift.y(), -0.1, 1e-9);
  EXPECT_NEAR(std::remainder(drift.z() - 0.2, 2 * M_PI), 0, 1e-9);
}

TEST(Feet, ABounceIsNoStepAndAScuffIsNoStance) {
  Walk walk;
  walk.on_left();
  walk.stay(1, 0.9, 0.1);
  walk.stay(2, 1, 0);  // 20 ms in the air
  walk.stay(1, 0.9, 0.1);
  walk.on_right();
  walk.samples[walk.samples.size() - 4].left.load_n = 0.05;  // the left one scuffs
  EXPECT_EQ(total(walk.rows(), FootPhase::put_down).rows, 1);
  EXPECT_EQ(total(walk.rows(), FootPhase::landing).rows, 1);
}

/// Ten seconds ahead at 0.1 m/s, a frame each second; the true waist is beside its path by the end by 50 mm,
/// in proportion to the time, and turned by 5 degrees. Two laps: 2 to 5 s and 5 to 8 s.
class Navigation : public RunTest {
 protected:
  Navigation() {
    run.desired.emplace();
    for (int i = 0; i <= 10; ++i) {
      const Stamp t = i * 1s;
      run.desired->waist.push_back({t, upright(0.1 * i, 0, 0.6)});
      run.plan_waist.push_back({t, upright(0.1 * i, -0.005 * i, 0.6)});
      run.truth_waist.push_back({t, upright(0.1 * i, 0.005 * i, 0.59, 0.5 * kDegree * i)});
      run.truth_camera.push_back({t, upright(0.1 * i, 0.005 * i, 0.6)});
    }
    run.desired->end = upright(1, 0, 0.6);
    run.desired->laps = {{2s, 5s}, {5s, 8s}};
  }
};

TEST_F(Navigation, ErrorsAreThoseOfTheTrueWaistFromTheCommandedPathOnTheGround) {
  double squares = 0;
  for (int i = 1; i <= 10; ++i) squares += std::pow(0.005 * i, 2);
  EXPECT_NEAR(value("navigation_rmse_m"), std::sqrt(squares / 10), 1e-12);
  EXPECT_NEAR(value("navigation_end_position_error_m"), 0.05, 1e-12);
  EXPECT_NEAR(value("navigation_end_yaw_error_deg"), 5, 1e-9);
  EXPECT_NEAR(value("navigation_first_lap_end_error_m"), 0.025, 1e-12);
  EXPECT_NEAR(value("navigation_last_lap_end_error_m"), 0.040, 1e-12);
}

TEST_F(Navigation, AWalkWithoutLapsOrThatFellInOneSaysSo) {
  run.truth_waist.resize(7);
  EXPECT_EQ(reason("navigation_last_lap_end_error_m"), "the lap was not finished");
  EXPECT_NEAR(value("navigation_first_lap_end_error_m"), 0.025, 1e-12);
  run.desired->laps.clear();
  EXPECT_EQ(reason("navigation_last_lap_end_error_m"), "the walk has no laps: no command is repeated");
  run.desired.reset();
  EXPECT_EQ(reason("navigation_rmse_m"), "no path was commanded");
}

TEST_F(Navigation, CorrectionsAreCountedAndMeasured) {
  EXPECT_EQ(reason("steps_corrected"), "the walk was not steered");
  run.steered = true;
  EXPECT_EQ(reason("steps_corrected"), "no footstep could be corrected");
  run.corrections = {{1s, 0.003, -0.004, 0}, {2s, 0, 0, -2 * kDegree}, {3s, 0, 0, 0}, {4s, 0, 0.001, 0}};
  EXPECT_EQ(value("steps_corrected"), 3);
  EXPECT_NEAR(value("correction_largest_m"), 0.005, 1e-12);
  EXPECT_NEAR(value("correction_largest_deg"), 2, 1e-9);
}

TEST_F(Navigation, TimelinessIsThatOfTheAnswers) {
  EXPECT_EQ(reason("dropped_frames"), "the estimator was not run");
  run.estimate.emplace();
  EXPECT_EQ(reason("latency_p99_ms"), "answers take no simulated time: estimator.time.model is none");
  run.timeliness = {{60, 70, 80}, {60, 60, 60}, 40, 1};
  for (const auto& [name, expected] : {std::pair("dropped_frames", 1.0),
                                       {"dropped_frames_fraction", 0.25},
                                       {"latency_median_ms", 70},
                                       {"latency_p99_ms", 80},
                                       {"budget_fraction_mean", 1.5},
                                       {"budget_fraction_p99", 1.5}})
    EXPECT_NEAR(value(name), expected, 0.25) << name;
}

// The corrections take back what the robot drifts, here 20 of the 360 degrees.
TEST_F(Navigation, TheLoopOfASteeredWalkIsThatOfItsCommands) {
  run.estimate.emplace();
  for (int i = 0; i <= 10; ++i) {
    run.desired->waist[i].X.linear() = about_z(36 * kDegree * i);
    run.plan_waist[i].X.linear() = about_z(34 * kDegree * i);
    run.estimate->push_back({run.truth_camera[i], {}});
  }
  const std::string too_little = "the executed part of the plan turns by less than 350 degrees";
  EXPECT_EQ(reason("loop_closed"), too_little);
  run.steered = true;
  EXPECT_NE(reason("loop_closed"), too_little);
}

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

TEST(LandmarkAccuracy, IsTheDistanceToTheSurfacePointFirstSeen) {
  score::Run run;
  run.truth_camera = {{Stamp(0), looking(0)}, {Stamp(1), looking(1)}};
  run.surfaces = {box_room(4)};
  run.camera = square_camera();
  // The pixel (80, 120) looks 26.6° to the left: at the wall x = 4 m the point (4, 2, 1.4).
  run.landmarks = {{1, {Stamp(0), {80, 120}}, {}}, {2, {Stamp(7), {80, 120}}, {}}};
  const Eigen::Vector3d p(4.03, 2, 1.36);
  run.map = {{1, p}, {2, p}, {3, p}};
  const auto found = landmark_errors(run);
  ASSERT_EQ(found.size(), 1u);  // 2 was first seen at an unknown pose, 3 has no history
  EXPECT_NEAR(found[0], 0.05, 1e-12);
  run.surfaces.clear();
  EXPECT_TRUE(landmark_errors(run).empty());  // no surface, no truth
}

}  // namespace
}  // namespace sim::score
