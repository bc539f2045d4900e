#include "sim/score/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <regex>
#include <set>

#include "sim/score/run.h"
#include "tests/sim/score/square_camera.h"

namespace sim::score {
namespace {

using std::chrono::milliseconds;
using std::numbers::pi;
using testing::HasSubstr;

// Stands for 2 s, then walks a circle of 1 m radius to the left in 40 s, camera ahead, in a room of 10 x 10 x
// 3 m.
Run circle() {
  Run run;
  run.estimate.emplace();
  for (int i = 0; i <= 420; ++i) {
    const double turn = 2 * pi * std::max(0, i - 20) / 400;
    const Eigen::Vector3d p(std::sin(turn), 1 - std::cos(turn), 0);
    const Stamp t = milliseconds(100 * i);
    Eigen::Isometry3d waist(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
    waist.translation() = p + Eigen::Vector3d(0, 0, 0.7);
    Eigen::Isometry3d camera = looking(turn);
    camera.translation() += p;
    run.truth_waist.push_back({t, waist});
    run.plan_waist.push_back({t, waist});
    run.truth_camera.push_back({t, camera});
    run.plan_camera.push_back({t, camera});
    run.estimate->push_back({t, camera, Matrix6d::Identity()});
  }
  run.surfaces.push_back(box_room(5));
  run.camera = square_camera();
  return run;
}

double value(const Metrics& metrics, const std::string& name) {
  const Metric& metric = metrics.at(name);
  EXPECT_TRUE(metric.value) << name << ": " << metric.reason;
  return metric.value.value_or(std::nan(""));
}

TEST(Evaluate, APerfectRunHasNoErrors) {
  const Metrics m = evaluate(circle());
  EXPECT_EQ(m.size(), metric_definitions().size());
  for (const char* name : {"rmse_m", "end_position_error_m", "end_yaw_error_deg", "height_range_m",
                           "true_height_range_m", "plan_drift_x_m", "plan_drift_y_m", "plan_drift_yaw_deg",
                           "plan_rmse_m", "loop_landmarks", "loop_closed", "nees_position_mean"})
    EXPECT_EQ(value(m, name), 0) << name;
  EXPECT_NEAR(value(m, "ate_se3_rmse_m"), 0, 1e-12);
  EXPECT_NEAR(value(m, "nees_orientation_mean"), 0, 1e-12);
  // 399 chords of the circle: the first frame that is moved (20 would not show) is 21.
  EXPECT_NEAR(value(m, "path_length_m"), 399 * 2 * std::sin(pi / 400), 1e-12);
}

TEST(Evaluate, AShiftShowsOnlyInTheUnalignedErrors) {
  auto run = circle();
  for (EstimatedPose& pose : *run.estimate) pose.X_WC.translation() += Eigen::Vector3d(0.3, 0, 0.4);
  const Metrics m = evaluate(run);
  EXPECT_NEAR(value(m, "rmse_m"), 0.5, 1e-12);
  EXPECT_NEAR(value(m, "end_position_error_m"), 0.5, 1e-12);
  EXPECT_NEAR(value(m, "ate_se3_rmse_m"), 0, 1e-12);
  EXPECT_NEAR(value(m, "nees_position_mean"), 0.25, 1e-12);  // covariance of 1 m² per axis
  EXPECT_EQ(m.at("rmse_m").unit, "m");
}

TEST(Evaluate, ErrorsBeforeTheFirstPlannedMotionDoNotCount) {
  auto run = circle();
  for (std::size_t i = 0; i <= 20; ++i) (*run.estimate)[i].X_WC.translation().z() += 100;
  EXPECT_EQ(value(evaluate(run), "rmse_m"), 0);
  EXPECT_EQ(value(evaluate(run), "height_range_m"), 0);
  (*run.estimate)[21].X_WC.translation().z() += 100;  // the first frame more than 1 mm away: 15.7 mm
  EXPECT_GT(value(evaluate(run), "rmse_m"), 1);
  EXPECT_NEAR(value(evaluate(run), "height_range_m"), 100, 1e-12);
}

TEST(Evaluate, EndErrorsAreOfTheLastFrame) {
  auto run = circle();
  Eigen::Isometry3d& end = run.estimate->back().X_WC;
  end.linear() = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()).toRotationMatrix() * end.linear();
  end.translation().y() += 0.02;
  const Metrics m = evaluate(run);
  EXPECT_NEAR(value(m, "end_position_error_m"), 0.02, 1e-12);
  EXPECT_NEAR(value(m, "end_yaw_error_deg"), 0.1 * 180 / pi, 1e-10);  // a size: not negative
  EXPECT_NEAR(value(m, "rmse_m"), 0.02 / std::sqrt(400.0), 1e-12);
}

TEST(Evaluate, PlanDriftIsTrueMinusPlannedAtTheEnd) {
  auto run = circle();
  Eigen::Isometry3d& end = run.truth_waist.back().X;
  end.translation() += Eigen::Vector3d(0.03, -0.05, 0.01);
  end.linear() = Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitZ()).toRotationMatrix() * end.linear();
  const Metrics m = evaluate(run);
  EXPECT_NEAR(value(m, "plan_drift_x_m"), 0.03, 1e-12);
  EXPECT_NEAR(value(m, "plan_drift_y_m"), -0.05, 1e-12);
  EXPECT_NEAR(value(m, "plan_drift_yaw_deg"), -0.2 * 180 / pi, 1e-10);
}

// `count` landmarks on the wall ahead at the start, seen again at the end.
std::vector<LandmarkHistory> closing(const Run& run, int count) {
  std::vector<LandmarkHistory> all;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d pixel(100 + 10 * i, 120);  // first and last pose are the same: so is the pixel
    all.push_back({i, {Stamp(0), pixel}, {{run.truth_camera.back().t, pixel}}});
  }
  return all;
}

TEST(Evaluate, TheLoopIsClosedByThreeLandmarks) {
  auto run = circle();
  run.landmarks = closing(run, 2);
  EXPECT_EQ(value(evaluate(run), "loop_landmarks"), 2);
  EXPECT_EQ(value(evaluate(run), "loop_closed"), 0);
  run.landmarks = closing(run, 3);
  EXPECT_EQ(value(evaluate(run), "loop_landmarks"), 3);
  EXPECT_EQ(value(evaluate(run), "loop_closed"), 1);
}

TEST(Evaluate, TheErrorsAboutTheClosureAreThoseBeforeAndASecondAfter) {
  auto run = circle();
  run.landmarks = closing(run, 3);
  const Stamp first = milliseconds(40600);  // of 42 s; one of the three is found again sooner than the others
  run.landmarks[1].accepted[0] = {
      first, *run.camera.project(run.truth_camera[406].X, Eigen::Vector3d(5, 5 * 50.0 / 160, 1.4))};
  for (EstimatedPose& pose : *run.estimate)
    pose.X_WC.translation().x() += pose.t < first ? 0.5 : pose.t < first + milliseconds(500) ? 9 : 0.125;
  const Metrics m = evaluate(run);
  EXPECT_EQ(value(m, "loop_landmarks"), 3);
  EXPECT_NEAR(value(m, "loop_time_s"), 40.6, 1e-12);
  EXPECT_NEAR(value(m, "loop_error_before_m"), 0.5, 1e-12);
  EXPECT_NEAR(value(m, "loop_error_after_m"), 0.125, 1e-12);
  run.landmarks.clear();
  EXPECT_EQ(evaluate(run).at("loop_error_after_m").reason, "no early landmark was found again");
}

TEST(Evaluate, ATooLargeEstimateShowsAsScale) {
  auto run = circle();
  for (EstimatedPose& pose : *run.estimate) pose.X_WC.translation() *= 1.02;
  const Metrics m = evaluate(run);
  EXPECT_NEAR(value(m, "scale_error_percent"), 2, 1e-9);
  EXPECT_NEAR(value(m, "ate_sim3_rmse_m"), 0, 1e-12);
  EXPECT_NEAR(value(m, "ate_se3_rmse_m"), 0.02,
              1e-4);  // a circle of 1 m radius grown by 2 %, its mean not quite in the middle
  EXPECT_NEAR(value(m, "ate_yaw_rmse_m"), value(m, "ate_se3_rmse_m"), 1e-6);  // the motion is in a plane
  // Over 1 m of the path the chord, 2 sin(½) = 0.959 m, grows by 2 %.
  EXPECT_NEAR(value(m, "rpe_1m_m"), 0.02 * 0.9589, 2e-4);  // spans of 1 m to half a frame, 8 mm
  EXPECT_NEAR(value(m, "rpe_1m_deg"), 0, 1e-6);
  EXPECT_NEAR(value(m, "drift_percent"), 100 * 0.02 * 1.4 / value(m, "path_length_m"),
              1e-9);  // ends at (0, 0, 1.4 m)
}

TEST(Evaluate, WithoutAFilterItsMetricsAreAbsentAndTheWalksAreNot) {
  auto run = circle();
  run.estimate.reset();
  const Metrics m = evaluate(run);
  for (const char* name :
       {"ate_se3_rmse_m", "rmse_m", "end_position_error_m", "end_yaw_error_deg", "height_range_m",
        "loop_landmarks", "loop_closed", "nees_position_mean", "nees_orientation_mean"}) {
    EXPECT_FALSE(m.at(name).value) << name;
    EXPECT_EQ(m.at(name).reason, "the filter was not run") << name;
    EXPECT_FALSE(m.at(name).unit.empty());
  }
  for (const char* name :
       {"true_height_range_m", "plan_drift_x_m", "plan_drift_yaw_deg", "path_length_m", "plan_rmse_m"})
    EXPECT_TRUE(m.at(name).value) << name;
}

TEST(Evaluate, AnEstimateThatFailedIsNotScoredAndItsWalkIs) {
  auto diverged = circle(), failed = circle();
  diverged.estimate->resize(200);
  diverged.diverged = "covariance not positive definite";
  failed.failed = "killed by signal 9";
  for (const char* name : {"ate_se3_rmse_m", "rmse_m", "loop_closed", "nees_position_mean"}) {
    EXPECT_EQ(evaluate(diverged).at(name).reason, "the filter diverged: covariance not positive definite");
    EXPECT_EQ(evaluate(failed).at(name).reason, "the estimator failed: killed by signal 9");
  }
  EXPECT_TRUE(evaluate(failed).at("path_length_m").value);
}

TEST(Evaluate, AFallBeforeTheTurnIsDoneLeavesTheLoopUndefined) {
  auto run = circle();
  for (Trajectory* t : {&run.truth_camera, &run.plan_camera, &run.truth_waist, &run.plan_waist})
    t->resize(300);
  run.estimate->resize(300);
  run.landmarks = closing(circle(), 3);
  const Metrics m = evaluate(run);
  EXPECT_THAT(m.at("loop_landmarks").reason, HasSubstr("less than 350 degrees"));
  EXPECT_FALSE(m.at("loop_closed").value);
  EXPECT_EQ(value(m, "rmse_m"), 0);
}

TEST(Evaluate, DegenerateRunsGiveReasonsNotNumbers) {
  for (const auto& [name, metric] : evaluate(score::Run{})) {
    EXPECT_FALSE(metric.value) << name;
    EXPECT_FALSE(metric.reason.empty()) << name;
  }
  auto standing = circle();
  for (Trajectory* t :
       {&standing.truth_camera, &standing.plan_camera, &standing.truth_waist, &standing.plan_waist})
    t->resize(20);
  standing.estimate->resize(20);
  EXPECT_EQ(evaluate(standing).at("rmse_m").reason, "the plan never moves");
  EXPECT_TRUE(evaluate(standing).at("plan_drift_x_m").value);
  auto straight = circle();
  for (std::size_t i = 0; i < straight.truth_camera.size(); ++i) {
    const double x = 0.01 * static_cast<double>(i);
    for (Eigen::Isometry3d* X : {&straight.truth_camera[i].X, &(*straight.estimate)[i].X_WC})
      X->translation() = Eigen::Vector3d(x, 0, 1);
  }
  EXPECT_THAT(evaluate(straight).at("ate_se3_rmse_m").reason, HasSubstr("one line"));
  EXPECT_EQ(value(evaluate(straight), "rmse_m"), 0);
}

TEST(Evaluate, OrientationErrorsAreTheirOwnMetric) {
  auto run = circle();
  for (EstimatedPose& pose : *run.estimate)
    pose.X_WC.linear() =
        Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()).toRotationMatrix() * pose.X_WC.linear();
  const Metrics m = evaluate(run);
  EXPECT_NEAR(value(m, "rotation_rmse_deg"), 0.02 * 180 / pi, 1e-10);
  EXPECT_EQ(value(m, "rmse_m"), 0);
  EXPECT_EQ(value(m, "poses_matched"), 400);
}

TEST(Evaluate, SpansOfAMeterAreFromEachFrame) {
  auto run = circle();
  for (std::size_t i = 0; i < run.estimate->size(); ++i)  // drifts up by 1 mm a frame: 10 mm a second
    (*run.estimate)[i].X_WC.translation().z() += 0.001 * static_cast<double>(i);
  const Metrics m = evaluate(run);
  // From each of 400 frames over the nearest whole number of frames; at the end
  // over the remaining ones, down to 90 % of the length.
  const auto expected = [](double frames) {
    const int whole = static_cast<int>(std::round(frames));
    double squares = (400 - whole) * whole * whole, count = 400 - whole;
    for (int left = whole - 1; left >= 0.9 * frames - 1e-9; --left) squares += left * left, ++count;
    return 0.001 * std::sqrt(squares / count);
  };
  const double frame = 2 * std::sin(pi / 400);  // m
  EXPECT_NEAR(value(m, "rpe_1m_m"), expected(1 / frame), 1e-12);
}

TEST(Evaluate, CompletionIsThePartOfThePlansTime) {
  auto run = circle();
  EXPECT_FALSE(evaluate(run).at("track_completion").value);
  run.planned = PlannedTimes{milliseconds(42090), {}};  // no room for another frame
  EXPECT_EQ(value(evaluate(run), "track_completion"), 1);
  run.estimate->resize(211);  // up to 21 s
  run.planned->end = milliseconds(84000);
  run.diverged = "lost";
  EXPECT_NEAR(value(evaluate(run), "track_completion"), 0.25, 1e-12);
}

TEST(Evaluate, TheTrackedAndTheFaultFlagFractionAreOfTheObservedTime) {
  auto run = circle();
  run.health.clear();
  EXPECT_FALSE(evaluate(run).at("tracked_fraction").value);
  // 4 s, the last one lost, and 1 s after a divergence; one observation is late
  run.health = {{milliseconds(0), true, false},     {milliseconds(2000), true, true},
                {milliseconds(1500), false, true},  {milliseconds(3000), true, false},
                {milliseconds(4000), false, false}, {milliseconds(5000), false, false}};
  EXPECT_NEAR(value(evaluate(run), "tracked_fraction"), 0.6, 1e-12);
  EXPECT_NEAR(value(evaluate(run), "fault_flag_fraction"), 0.4, 1e-12);
  run.diverged = "lost";
  EXPECT_NEAR(value(evaluate(run), "tracked_fraction"), 0.6, 1e-12);
}

TEST(Evaluate, NeesHasMeanVarianceAndThePartWithinItsBand) {
  auto run = circle();
  for (std::size_t i = 0; i < run.estimate->size(); ++i)  // squares of 1 and 9 in turns
    (*run.estimate)[i].X_WC.translation().z() += i % 2 == 0 ? 1 : 3;
  const Metrics m = evaluate(run);
  EXPECT_NEAR(value(m, "nees_position_mean"), 5, 1e-12);
  EXPECT_NEAR(value(m, "nees_position_variance"), 16 * 400.0 / 399, 1e-10);
  EXPECT_NEAR(value(m, "nees_position_within_95"), 0.5, 1e-12);
  EXPECT_NEAR(value(m, "nees_orientation_within_95"), 1, 1e-12);
}

TEST(Evaluate, InnovationsBeforeTheFirstMotionDoNotCount) {
  auto run = circle();
  for (int i = 0; i <= 420; ++i)
    run.innovations[1].push_back({milliseconds(100 * i), {i <= 20 ? 1000.0 : i % 2 == 0 ? 2.0 : 4.0, 3}});
  const Metrics m = evaluate(run);
  EXPECT_NEAR(value(m, "nis_gyro_mean"), 1, 1e-12);
  EXPECT_NEAR(value(m, "nis_gyro_variance"), 1.0 / 6, 1e-12);  // 1 from the mean; chi² of 3: variance 6
  EXPECT_EQ(m.at("nis_vision_mean").reason, "the sensor was used in fewer than two frames");
}

TEST(Evaluate, LandmarksAreComparedWithTheWallsTheyWereSeenOn) {
  auto run = circle();
  // Straight ahead of the first camera, at (0, 0, 1.4 m): the wall x = 5 m.
  for (int id = 1; id <= 2; ++id) {
    run.landmarks.push_back({id, {Stamp(0), {160, 120}}, {}});
    run.map.push_back({id, Eigen::Vector3d(5, 0, 1.4 + 0.3 * id), 0.09 * Eigen::Matrix3d::Identity()});
  }
  run.landmarks[0].first_seen.t = run.landmarks[1].first_seen.t = run.truth_camera[21].t;
  const Eigen::Isometry3d& X_WC = run.truth_camera[21].X;
  for (auto& landmark : run.landmarks)
    landmark.first_seen.pixel = *run.camera.project(X_WC, Eigen::Vector3d(5, 0, 1.4));
  const Metrics m = evaluate(run);
  EXPECT_NEAR(value(m, "landmark_rmse_m"), std::sqrt((0.09 + 0.36) / 2), 1e-9);
  EXPECT_NEAR(value(m, "landmark_nees_mean"), (1 + 4) / 2.0, 1e-9);
}

TEST(Evaluate, NonFiniteNumbersBecomeReasons) {
  auto run = circle();
  (*run.estimate)[50].X_WC.translation().x() = std::nan("");
  const Metrics m = evaluate(run);
  for (const char* name : {"rmse_m", "ate_se3_rmse_m", "nees_position_mean"}) {
    EXPECT_FALSE(m.at(name).value) << name;
    EXPECT_FALSE(m.at(name).reason.empty()) << name;
  }
  run = circle();
  (*(*run.estimate)[50].covariance)(0, 0) = -1;
  EXPECT_THAT(evaluate(run).at("nees_position_mean").reason, HasSubstr("positive definite"));
}

TEST(Evaluate, AnEstimatorWithoutCovarianceHasNoNeesAndTheReasonSaysSo) {
  auto run = circle();
  for (EstimatedPose& pose : *run.estimate) pose.covariance.reset();
  const Metrics m = evaluate(run);
  for (const char* name :
       {"nees_position_mean", "nees_position_variance", "nees_position_within_95", "nees_orientation_mean",
        "nees_orientation_variance", "nees_orientation_within_95"}) {
    EXPECT_FALSE(m.at(name).value) << name;
    EXPECT_EQ(m.at(name).reason, "the estimator states no covariance") << name;
  }
  EXPECT_TRUE(m.at("rmse_m").value);
  for (std::size_t i = 30; i < 40; ++i) (*run.estimate)[i].covariance = Matrix6d::Identity();
  EXPECT_EQ(value(evaluate(run), "nees_position_mean"), 0) << "of the poses with a covariance";
  EXPECT_EQ(value(evaluate(run), "poses_with_covariance"), 10);
}

TEST(Evaluate, AnEstimatorThatReportsNoMatchesHasNoLoopAndTheReasonSaysSo) {
  auto run = circle();
  run.no_matches = "no matches";
  EXPECT_EQ(evaluate(run).at("loop_closed").reason, "no matches");
  EXPECT_EQ(evaluate(run).at("loop_landmarks").reason, "no matches");
}

TEST(Evaluate, AnErrorAtAnEndBeforeThatOfTheWalkSaysWhenThatWas) {
  auto run = circle();
  EXPECT_EQ(evaluate(run).at("end_position_error_m").note, "");
  run.estimate->resize(106);
  EXPECT_EQ(evaluate(run).at("end_position_error_m").note, "at 10.5 s, 25 % of 42.0 s");
  EXPECT_EQ(evaluate(run).at("rmse_m").note, "");
  EXPECT_EQ(evaluate(run).at("plan_drift_x_m").note, "");
  EXPECT_EQ(value(evaluate(run), "poses_matched"), 85);
  EXPECT_EQ(value(evaluate(run), "true_poses"), 400);
  run.planned = PlannedTimes{milliseconds(525000), {}};
  EXPECT_EQ(evaluate(run).at("plan_drift_x_m").note, "at 42.0 s, 8 % of 525.0 s");
}

TEST(Evaluate, WithoutAScaleLengthsHaveNoValueAndTheRestHas) {
  auto run = circle();
  run.no_scale = "the scale is unknown";
  const Metrics m = evaluate(run);
  for (const char* name : {"rmse_m", "ate_se3_rmse_m", "rpe_1m_m", "drift_percent", "height_range_m",
                           "scale_error_percent", "nees_position_mean", "loop_error_before_m"}) {
    EXPECT_FALSE(m.at(name).value) << name;
    EXPECT_EQ(m.at(name).reason, "the scale is unknown") << name;
  }
  for (const char* name : {"ate_sim3_rmse_m", "rotation_rmse_deg", "rpe_1m_deg", "nees_orientation_mean",
                           "path_length_m", "loop_landmarks"})
    EXPECT_TRUE(m.at(name).value) << name << ": " << m.at(name).reason;
}

TEST(Evaluate, EveryMetricHasOneDefinitionAndTheUnitOfItsName) {
  std::set<std::string_view> names;
  for (const MetricDefinition& d : metric_definitions()) {
    EXPECT_TRUE(names.insert(d.name).second) << d.name;
    EXPECT_GT(d.definition.size(), 20u) << d.name;
    if (d.name.ends_with("_m")) {
      EXPECT_EQ(d.unit, "m");
    } else if (d.name.ends_with("_deg")) {
      EXPECT_EQ(d.unit, "deg");
    } else if (d.name.ends_with("_s")) {
      EXPECT_EQ(d.unit, "s");
    } else if (d.name.ends_with("_percent")) {
      EXPECT_EQ(d.unit, "%");
    } else {
      EXPECT_EQ(d.unit, "1");
    }
  }
}

// A filter with a NEES or NIS far below its expectation is as inconsistent as one far above it.
TEST(Evaluate, MetricsWithAnExpectedValueBecomeWorseOnBothSidesOfIt) {
  const std::regex expectation("; ([0-9.]+) is expected");
  int found = 0;
  for (const MetricDefinition& d : metric_definitions()) {
    std::smatch match;
    const bool expects = std::regex_search(d.definition, match, expectation) && match[1] != "0";
    EXPECT_EQ(d.direction.worst == Worst::farthest_from_expected, expects) << d.name;
    if (!expects) continue;
    EXPECT_EQ(d.direction.expected, std::stod(match[1])) << d.name;
    ++found;
  }
  EXPECT_GE(found, 7);
  EXPECT_EQ(direction_of("whatever").worst, Worst::largest);
}

}  // namespace
}  // namespace sim::score
