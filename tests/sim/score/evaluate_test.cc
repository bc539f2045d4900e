#include "sim/score/evaluate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <set>

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
  Surface room{Surface::Kind::box, Eigen::Isometry3d::Identity(), {5, 5, 1.5}};
  room.X_WS.translation().z() = 1.5;
  run.surfaces.push_back(room);
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

TEST(Evaluate, AShiftShowsInTheUnalignedErrorsAlone) {
  score::Run run = circle();
  for (EstimatedPose& pose : *run.estimate) pose.X_WC.translation() += Eigen::Vector3d(0.3, 0, 0.4);
  const Metrics m = evaluate(run);
  EXPECT_NEAR(value(m, "rmse_m"), 0.5, 1e-12);
  EXPECT_NEAR(value(m, "end_position_error_m"), 0.5, 1e-12);
  EXPECT_NEAR(value(m, "ate_se3_rmse_m"), 0, 1e-12);
  EXPECT_NEAR(value(m, "nees_position_mean"), 0.25, 1e-12);  // covariance of 1 m² per axis
  EXPECT_EQ(m.at("rmse_m").unit, "m");
}

TEST(Evaluate, ErrorsBeforeTheFirstPlannedMotionDoNotCount) {
  score::Run run = circle();
  for (std::size_t i = 0; i <= 20; ++i) (*run.estimate)[i].X_WC.translation().z() += 100;
  EXPECT_EQ(value(evaluate(run), "rmse_m"), 0);
  EXPECT_EQ(value(evaluate(run), "height_range_m"), 0);
  (*run.estimate)[21].X_WC.translation().z() += 100;  // the first frame more than 1 mm away: 15.7 mm
  EXPECT_GT(value(evaluate(run), "rmse_m"), 1);
  EXPECT_NEAR(value(evaluate(run), "height_range_m"), 100, 1e-12);
}

TEST(Evaluate, EndErrorsAreOfTheLastFrame) {
  score::Run run = circle();
  Eigen::Isometry3d& end = run.estimate->back().X_WC;
  end.linear() = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()).toRotationMatrix() * end.linear();
  end.translation().y() += 0.02;
  const Metrics m = evaluate(run);
  EXPECT_NEAR(value(m, "end_position_error_m"), 0.02, 1e-12);
  EXPECT_NEAR(value(m, "end_yaw_error_deg"), 0.1 * 180 / pi, 1e-10);  // a size: not negative
  EXPECT_NEAR(value(m, "rmse_m"), 0.02 / std::sqrt(400.0), 1e-12);
}

TEST(Evaluate, PlanDriftIsTrueMinusPlannedAtTheEnd) {
  score::Run run = circle();
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
  score::Run run = circle();
  run.landmarks = closing(run, 2);
  EXPECT_EQ(value(evaluate(run), "loop_landmarks"), 2);
  EXPECT_EQ(value(evaluate(run), "loop_closed"), 0);
  run.landmarks = closing(run, 3);
  EXPECT_EQ(value(evaluate(run), "loop_landmarks"), 3);
  EXPECT_EQ(value(evaluate(run), "loop_closed"), 1);
}

TEST(Evaluate, TheErrorsAboutTheClosureAreThoseBeforeAndASecondAfter) {
  score::Run run = circle();
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
  EXPECT_EQ(evaluate(run).at("loop_error_after_m").reason, "no landmark closed the loop");
}

TEST(Evaluate, ATooLargeEstimateShowsAsScale) {
  score::Run run = circle();
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
  score::Run run = circle();
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

TEST(Evaluate, ADivergedFilterGetsNoNumbersButTheCause) {
  score::Run run = circle();
  run.estimate->resize(200);
  run.diverged = "covariance not positive definite";
  for (const char* name : {"ate_se3_rmse_m", "rmse_m", "loop_closed", "nees_position_mean"}) {
    EXPECT_FALSE(evaluate(run).at(name).value);
    EXPECT_EQ(evaluate(run).at(name).reason, "the filter diverged: covariance not positive definite");
  }
}

TEST(Evaluate, AFallBeforeTheTurnIsDoneLeavesTheLoopUndefined) {
  score::Run run = circle();
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
  score::Run standing = circle();
  for (Trajectory* t :
       {&standing.truth_camera, &standing.plan_camera, &standing.truth_waist, &standing.plan_waist})
    t->resize(20);
  standing.estimate->resize(20);
  EXPECT_EQ(evaluate(standing).at("rmse_m").reason, "the plan never moves");
  EXPECT_TRUE(evaluate(standing).at("plan_drift_x_m").value);
  score::Run straight = circle();
  for (std::size_t i = 0; i < straight.truth_camera.size(); ++i) {
    const double x = 0.01 * static_cast<double>(i);
    for (Eigen::Isometry3d* X : {&straight.truth_camera[i].X, &(*straight.estimate)[i].X_WC})
      X->translation() = Eigen::Vector3d(x, 0, 1);
  }
  EXPECT_THAT(evaluate(straight).at("ate_se3_rmse_m").reason, HasSubstr("one line"));
  EXPECT_EQ(value(evaluate(straight), "rmse_m"), 0);
}

TEST(Evaluate, NumbersThatAreNoneBecomeReasons) {
  score::Run run = circle();
  (*run.estimate)[50].X_WC.translation().x() = std::nan("");
  const Metrics m = evaluate(run);
  for (const char* name : {"rmse_m", "ate_se3_rmse_m", "nees_position_mean"}) {
    EXPECT_FALSE(m.at(name).value) << name;
    EXPECT_FALSE(m.at(name).reason.empty()) << name;
  }
  run = circle();
  (*run.estimate)[50].covariance(0, 0) = -1;
  EXPECT_THAT(evaluate(run).at("nees_position_mean").reason, HasSubstr("positive definite"));
}

TEST(Evaluate, EveryMetricIsDefinedInWordsOnceAndSaysItsUnit) {
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

}  // namespace
}  // namespace sim::score
