// The drift of the walk due to its feet, navigation, and landmarks compared with the true room.
#include "sim/score/types.h"
#include "tests/sim/score/score_fixtures.h"

namespace sim::score {
namespace {

using namespace std::chrono_literals;
using Kind = Surface::Kind;
using Eigen::Vector3d, std::chrono::milliseconds, std::numbers::pi;

// A walk in place with one sample per 10 ms, feet at y = ±0.1 and 10 samples per support.
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

TEST(Feet, ATurnOfTheStandingFootSwingsTheRestOfThePathAboutIt) {
  Walk walk;
  walk.on_left(5);
  walk.left().truth.z() += 0.01;
  walk.right().truth = {-0.01 * -0.2, -0.1, 0.01};  // the swing foot moves with the body
  walk.on_left(5);
  walk.both();
  const auto rows = walk.rows({1, 0.11, 0.01}, {1, 0.1, 0});
  const Total support = total(rows, FootPhase::support);
  EXPECT_NEAR(support.turned, 0.01, 1e-12);
  EXPECT_NEAR(support.drift.z(), 0.01, 1e-12);
  EXPECT_NEAR(support.drift.y(), std::sin(0.01), 1e-12);  // 1 m ahead of the foot
  EXPECT_NEAR(total(rows, FootPhase::put_down).drift.y(), 0, 1e-4);
}

TEST(Feet, AFootPutDownBesideItsPlaceIsALandingErrorNotSlip) {
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

TEST(Feet, AFootThatDragsAfterTheOtherHasLandedDoesNotCountAsDrift) {
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

TEST(Feet, AFootSlidingAsItLandsIsDistinguishedFromOneSlidingUnderLoad) {
  Walk walk;
  walk.on_left();
  walk.stay(3, 0.9, 0.1);
  walk.right().truth.x() += 0.002;
  walk.right().creep.x() = 0.0005;  // in each of the later samples
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

TEST(Feet, AllContributionsAddUpToTheDriftOfTheWaist) {
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

TEST(Feet, ABounceIsNotAStepAndAScuffIsNotAStance) {
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

/// Ten seconds straight ahead at 0.1 m/s with a frame every second. In proportion to time, the true waist
/// drifts off its path by 50 mm and turns by 5 degrees at the end. Two laps: 2 to 5 s and 5 to 8 s.
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

TEST_F(Navigation, ErrorsAreDistancesOfTheTrueWaistFromTheCommandedPath) {
  double squares = 0;
  for (int i = 1; i <= 10; ++i) squares += std::pow(0.005 * i, 2);
  EXPECT_NEAR(value("navigation_rmse_m"), std::sqrt(squares / 10), 1e-12);
  EXPECT_NEAR(value("navigation_end_position_error_m"), 0.05, 1e-12);
  EXPECT_NEAR(value("navigation_end_yaw_error_deg"), 5, 1e-9);
  EXPECT_NEAR(value("navigation_first_lap_end_error_m"), 0.025, 1e-12);
  EXPECT_NEAR(value("navigation_last_lap_end_error_m"), 0.040, 1e-12);
}

TEST_F(Navigation, AWalkWithoutLapsOrWithAFallInOneSaysSo) {
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

TEST_F(Navigation, TimelinessRefersToTheAnswers) {
  EXPECT_EQ(reason("dropped_frames"), "the estimator was not run");
  run.estimate.emplace();
  EXPECT_EQ(reason("latency_p99_ms"), "answers take no simulated time with estimator.time.model: none");
  run.timeliness = {{60, 70, 80}, {60, 60, 60}, 40, 1};
  const std::map<std::string, double> expected{
      {"dropped_frames", 1},  {"dropped_frames_fraction", 0.25}, {"latency_median_ms", 70},
      {"latency_p99_ms", 80}, {"budget_fraction_mean", 1.5},     {"budget_fraction_p99", 1.5}};
  for (const auto& [name, number] : expected) EXPECT_NEAR(value(name), number, 0.25) << name;
}

// Computed by hand for shapes at the origin and rays along axes. The lidar tests compare rays in rooms with
// MuJoCo's.
TEST(Surfaces, TheNearestHitIsWhereGeometryPredicts) {
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
  EXPECT_EQ(hit(Kind::triangle, {2, 1, 4}, {1.2, 1.5, 5}, -z), 5);
  EXPECT_EQ(hit(Kind::triangle, {2, 1, 4}, {1.2, 1.5, -5}, z), 5);
  EXPECT_EQ(hit(Kind::triangle, {2, 1, 4}, {1.8, 1.5, 5}, -z), std::nullopt);
  EXPECT_EQ(hit(Kind::plane, {0, 0, 1}, {100, 100, 5}, -z), 5);
  EXPECT_EQ(hit(Kind::plane, {0, 0, 1}, {0, 0, -5}, z), std::nullopt);  // from below it is not seen
  EXPECT_EQ(hit(Kind::plane, {1, 2, 1}, {0.9, 1.9, 5}, -z), 5);
  EXPECT_EQ(hit(Kind::plane, {1, 2, 1}, {1.1, 0, 5}, -z), std::nullopt);
  const Surface near{Kind::box, upright(5, 0, 0), {1, 1, 1}}, far{Kind::box, upright(10, 0, 0), {1, 1, 1}};
  EXPECT_EQ(first_hit({far, near}, Vector3d::Zero(), x), 4);
  EXPECT_EQ(first_hit({far}, Vector3d::Zero(), x), 9);
  EXPECT_EQ(first_hit({far, near}, Vector3d::Zero(), Vector3d::UnitY()), std::nullopt);
}

// A camera in front of a wall 4 m ahead (x = 4 m), one frame every 0.1 s for 40 s. It looks ahead, except
// during an excursion. The landmark is first seen in the middle of the image at 1 s and matched again at 39.9
// s.
struct Excursion {
  explicit Excursion(const Eigen::Isometry3d& elsewhere = looking(pi), int from_ms = 15000,
                     int to_ms = 25000) {
    run.surfaces = {{Surface::Kind::box, upright(5, 0, 1.5), {1, 30, 30}}};
    run.camera = square_camera();
    for (int t = 0; t <= 40000; t += 100)
      run.truth_camera.push_back({milliseconds(t), t >= from_ms && t <= to_ms ? elsewhere : looking(0)});
    run.landmarks = {
        {7, {milliseconds(1000), kMiddle}, {{milliseconds(1100), kMiddle}, {milliseconds(39900), kMiddle}}}};
  }

  std::vector<StampedPixel>& accepted() { return run.landmarks.front().accepted; }
  // Returns the landmarks found again, or nothing if the camera did not return from elsewhere.
  std::optional<std::vector<LoopLandmark>> found() const {
    const auto all = loop_landmarks(run);
    return std::holds_alternative<Absent>(all) ? std::nullopt : std::optional(std::get<0>(all));
  }
  bool closes() const { return found() && !found()->empty(); }

  static inline const Eigen::Vector2d kMiddle{160, 120};
  Run run;
};

Eigen::Isometry3d aside(double left_m) {
  Eigen::Isometry3d X = looking(0);
  X.translation().y() = left_m;
  return X;
}

TEST(LoopClosure, CountsALandmarkFoundAgainWithinThreePixelsAfterTheCameraWasElsewhere) {
  for (const double off : {0.0, 2.9, -2.9, 4.0, -3.1}) {
    Excursion walk;
    walk.accepted().back().pixel.x() += off;
    ASSERT_TRUE(walk.found());
    EXPECT_EQ(walk.closes(), std::abs(off) < 3) << off;
  }
  Excursion unmatched, without_room;
  unmatched.accepted().pop_back();
  EXPECT_TRUE(unmatched.found() && !unmatched.closes()) << "it returned, and the landmark was not found";
  without_room.run.surfaces.clear();
  EXPECT_FALSE(without_room.found());
}

TEST(LoopClosure, ElsewhereIsAHeadingOrPlaceWhereNothingOfTheLastImageIsInViewAndTheLandmarkIsNotFor5s) {
  EXPECT_FALSE(Excursion(looking(pi), 20000, 24900).found());
  EXPECT_TRUE(Excursion(looking(pi), 20000, 25000).closes());
  Excursion seen_between(looking(pi), 20000, 28000);  // two intervals of 3 s and 4.9 s
  seen_between.run.truth_camera[230].X = looking(0);
  EXPECT_FALSE(seen_between.found());
  Excursion before(looking(pi), 0, 8900);  // before it is first seen
  before.run.landmarks.front().first_seen.t = milliseconds(9500);
  EXPECT_FALSE(before.found());
  // The camera sees 90 degrees, and 8 m of the wall. The landmark leaves the view at 45 degrees and at 4 m.
  for (const double degrees : {50, 85, 95, 180, -85, -95})
    EXPECT_EQ(Excursion(looking(degrees * kDegree)).closes(), std::abs(degrees) > 90) << degrees;
  for (const double left_m : {4.5, 7.5, 8.5, -7.5, -8.5})
    EXPECT_EQ(Excursion(aside(left_m)).closes(), std::abs(left_m) > 8) << left_m;
}

TEST(LoopClosure, WorksForAnyPathAtTheFirstMatchAfterTheReturn) {
  Excursion eight, straight(looking(0));  // turns to the left for 20 s, back to the right for 20 s
  for (std::size_t i = 0; i <= 400; ++i) {
    eight.run.truth_camera[i].X = looking(2 * pi * double(i < 200 ? i : 400 - i) / 200);
    straight.run.truth_camera[i].X.translation().x() = -0.01 * double(400 - i);
  }
  EXPECT_FALSE(straight.found());
  const Eigen::Vector3d p_W = eight.run.truth_camera[10].X * Eigen::Vector3d(0, 0, 1);
  eight.accepted().clear();
  for (const int t : {1100, 19000, 19500, 39000})
    eight.accepted().push_back(
        {milliseconds(t), *eight.run.camera.project(eight.run.truth_camera[std::size_t(t / 100)].X, p_W)});
  ASSERT_TRUE(eight.found());
  ASSERT_EQ(eight.found()->size(), 1U) << "once, no matter how often it is matched";
  EXPECT_EQ(eight.found()->front().found, milliseconds(19000));
}

TEST(LoopClosure, AMatchOfTheRightPixelButAnotherSurfacePointDoesNotCount) {
  // A post stands between: the point first seen is on the post, not on the wall behind it.
  Excursion walk;
  walk.run.surfaces.push_back({Surface::Kind::cylinder, upright(1, 0, 1.5), {0.1, 1.5, 0}});
  for (TimedPose& pose : walk.run.truth_camera)
    if (pose.t > milliseconds(30000)) pose.X = aside(0.2);  // parallax separates the two
  const auto closes_at = [&](double x) {
    walk.accepted().back().pixel = *walk.run.camera.project(aside(0.2), {x, 0, 1.4});
    return walk.closes();
  };
  EXPECT_FALSE(closes_at(4));
  EXPECT_TRUE(closes_at(0.9));
}

TEST(Vibration, IsSplitByFrequency) {
  score::Run run;
  run.truth_camera = {{Stamp(0), upright(0, 0, 1)}};
  for (int i = 0; i < 2000; ++i) {  // 10 s: 3 m/s² at 1 Hz ahead, 1 m/s² at 20 Hz upward, and gravity
    const double angle = 2 * pi * 0.005 * i;
    run.forces.push_back({i * 5ms, {3 * std::sin(angle), 0, 9.81 + std::cos(20 * angle)}});
  }
  const Metrics metrics = evaluate(run);
  EXPECT_NEAR(metrics.at("vibration_below_2hz_m_s2").value.value(), 3 / std::sqrt(2), 0.02);
  EXPECT_NEAR(metrics.at("vibration_2_to_8hz_m_s2").value.value(), 0, 0.15);
  EXPECT_NEAR(metrics.at("vibration_from_8hz_m_s2").value.value(), 1 / std::sqrt(2), 0.02);
}

}  // namespace
}  // namespace sim::score
