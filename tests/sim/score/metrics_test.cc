#include "sim/score/metrics.h"

#include "tests/sim/score/score_fixtures.h"

namespace sim::score {
namespace {

using std::chrono::milliseconds, std::numbers::pi, testing::HasSubstr;

/// Stands for 2 s, then walks a circle of 1 m radius to the left in 40 s, in a room of 10 x 10 x 3 m.
class Evaluate : public RunTest {
 protected:
  Evaluate() {
    run.estimate.emplace();
    for (int i = 0; i <= 420; ++i) {
      const double turn = 2 * pi * std::max(0, i - 20) / 400;
      const Stamp t = milliseconds(100 * i);
      const Eigen::Isometry3d waist = upright(std::sin(turn), 1 - std::cos(turn), 0.7, turn);
      Eigen::Isometry3d camera = looking(turn);
      camera.translation().head<2>() = waist.translation().head<2>();
      for (Trajectory* all : {&run.truth_waist, &run.plan_waist}) all->push_back({t, waist});
      for (Trajectory* all : {&run.truth_camera, &run.plan_camera}) all->push_back({t, camera});
      run.estimate->push_back({{t, camera}, Matrix6d::Identity()});
    }
    run.surfaces.push_back(box_room(5));
    run.camera = square_camera();
  }
  Eigen::Isometry3d& estimate(std::size_t i) { return (*run.estimate)[i].X; }
  void move_estimates(const Eigen::Vector3d& by) {
    for (files::TumRow& pose : *run.estimate) pose.X.translation() += by;
  }
  void end_after(std::size_t poses) {
    for (Trajectory* all : {&run.truth_camera, &run.plan_camera, &run.truth_waist, &run.plan_waist})
      all->resize(poses);
    run.estimate->resize(poses);
  }
  // Landmarks on the wall ahead at the start, seen again at the end.
  void close_loop(int count) {
    run.landmarks.clear();
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d pixel(100 + 10 * i, 120);  // first and last pose are the same: so is the pixel
      run.landmarks.push_back({i, {Stamp(0), pixel}, {{run.truth_camera.back().t, pixel}}});
    }
  }
};

TEST_F(Evaluate, TheLoopIsClosedByThreeLandmarksUnlessTheWalkDoesNotReturn) {
  for (const int count : {2, 3}) {
    close_loop(count);
    EXPECT_EQ(value("loop_landmarks"), count);
    EXPECT_EQ(value("loop_closed"), count == 3);
  }
  run.no_matches = "no matches";
  EXPECT_EQ(reason("loop_closed"), "no matches");
  EXPECT_EQ(reason("loop_landmarks"), "no matches");
  run.no_matches.reset();
  end_after(300);  // by a fall
  for (const char* name : {"loop_landmarks", "loop_closed"})
    EXPECT_THAT(reason(name), HasSubstr("never returned"));
  EXPECT_EQ(value("rmse_m"), 0);
}

TEST_F(Evaluate, ErrorsAroundAClosureAreTakenBeforeItsFirstMatchAndASecondAfter) {
  close_loop(4);  // the last one at the end, after 42 s
  for (const auto& [i, frame] : {std::pair(2, 406), std::pair(0, 412), std::pair(1, 408)}) {
    LandmarkHistory& landmark = run.landmarks[std::size_t(i)];
    const Eigen::Vector3d on_wall(5, 5 * (160 - landmark.first_seen.pixel.x()) / 160, 1.4);
    const TimedPose& again = run.truth_camera[std::size_t(frame)];
    landmark.accepted = {{again.t, *run.camera.project(again.X, on_wall)}};
  }
  const Stamp first = milliseconds(40600);
  for (files::TumRow& pose : *run.estimate)
    pose.X.translation().x() += pose.t < first ? 0.5 : pose.t < first + milliseconds(500) ? 9 : 0.125;
  EXPECT_EQ(value("loop_landmarks"), 4);
  EXPECT_NEAR(value("loop_time_s"), 40.6, 1e-12);
  EXPECT_NEAR(value("loop_error_before_m"), 0.5, 1e-12);
  EXPECT_NEAR(value("loop_error_after_m"), 0.125, 1e-12);
  close_loop(2);
  EXPECT_EQ(reason("loop_error_after_m"), "2 landmarks were found again; 3 close a loop");
}

TEST_F(Evaluate, APositionOnlyTruthIsScoredByTheErrorsAfterAlignment) {
  run.truth_has_poses = false;
  for (TimedPose& pose : run.truth_camera) pose.X.linear().setIdentity();
  for (const char* name : {"ate_se3_rmse_m", "ate_sim3_rmse_m", "poses_matched", "path_length_m"})
    EXPECT_TRUE(metric(name).value) << name;
  for (const char* name :
       {"rmse_m", "rotation_rmse_deg", "rpe_1m_m", "end_yaw_error_deg", "nees_orientation_mean"})
    EXPECT_THAT(reason(name), HasSubstr("the truth has only positions")) << name;
}

TEST_F(Evaluate, AMissingOrFailedEstimateIsNotScoredButItsWalkIs) {
  score::Run without = run, diverged = run, failed = run;
  without.estimate.reset();
  diverged.estimate->resize(200);
  diverged.diverged = "covariance is not positive definite";
  failed.failed = "killed by signal 9";
  for (const auto& [each, why] : {std::pair(without, "the estimator was not run"),
                                  {diverged, "the estimator diverged: covariance is not positive definite"},
                                  {failed, "the estimator failed: killed by signal 9"}}) {
    run = each;
    for (const char* name :
         {"ate_se3_rmse_m", "rmse_m", "end_position_error_m", "end_yaw_error_deg", "height_range_m",
          "loop_landmarks", "loop_closed", "nees_position_mean", "nees_orientation_mean"}) {
      EXPECT_EQ(reason(name), why) << name;
      EXPECT_FALSE(metric(name).unit.empty());
    }
    for (const char* name : {"true_height_range_m", "plan_drift_x_m", "path_length_m", "plan_rmse_m"})
      EXPECT_TRUE(metric(name).value) << name;
  }
}

TEST_F(Evaluate, DegenerateRunsGiveReasonsNotNumbers) {
  for (const auto& [name, found] : evaluate(score::Run{})) {
    EXPECT_FALSE(found.value) << name;
    EXPECT_FALSE(found.reason.empty()) << name;
  }
  for (std::size_t i = 0; i < run.truth_camera.size(); ++i)
    run.truth_camera[i].X.translation() = estimate(i).translation() = Eigen::Vector3d(0.01 * double(i), 0, 1);
  EXPECT_THAT(reason("ate_se3_rmse_m"), HasSubstr("one line"));
  EXPECT_EQ(value("rmse_m"), 0);
  estimate(50).translation().x() = std::nan("");
  for (const char* name : {"rmse_m", "ate_se3_rmse_m", "nees_position_mean"}) EXPECT_NE(reason(name), "");
  end_after(20);
  EXPECT_EQ(reason("rmse_m"), "the plan never moves");
  EXPECT_TRUE(metric("plan_drift_x_m").value);
}

TEST_F(Evaluate, CompletionTrackedAndFaultFlagAreFractionsOfTime) {
  for (const char* name : {"track_completion", "tracked_fraction"}) EXPECT_NE(reason(name), "");
  run.plan_end = milliseconds(42090);  // no room for another frame
  EXPECT_EQ(value("track_completion"), 1);
  run.estimate->resize(211);  // up to 21 s
  run.plan_end = milliseconds(84000);
  run.diverged = "lost";
  EXPECT_NEAR(value("track_completion"), 0.25, 1e-12);
  // 4 s, the last one lost, and 1 s after a divergence; one observation is late
  run.health = {{milliseconds(0), true, false},     {milliseconds(2000), true, true},
                {milliseconds(1500), false, true},  {milliseconds(3000), true, false},
                {milliseconds(4000), false, false}, {milliseconds(5000), false, false}};
  EXPECT_NEAR(value("tracked_fraction"), 0.6, 1e-12);
  EXPECT_NEAR(value("fault_flag_fraction"), 0.4, 1e-12);
}

TEST_F(Evaluate, NeesCoversOnlyPosesWithACovariance) {
  for (std::size_t i = 0; i < run.estimate->size(); ++i)  // squares of 1 and 9 alternately
    estimate(i).translation().z() += i % 2 == 0 ? 1 : 3;
  EXPECT_NEAR(value("nees_position_mean"), 5, 1e-12);
  EXPECT_EQ(value("poses_with_covariance"), 400);
  for (files::TumRow& pose : *run.estimate) pose.covariance.reset();
  for (const char* name : {"nees_position_mean", "nees_orientation_mean"})
    EXPECT_EQ(reason(name), "the estimator states no covariance");
  for (std::size_t i = 30; i < 40; i += 2) (*run.estimate)[i].covariance = Matrix6d::Identity();
  EXPECT_EQ(value("nees_position_mean"), 1);
  EXPECT_EQ(value("poses_with_covariance"), 5);
  for (const double none : {-1.0, 0.0, std::nan("")}) {
    (*(*run.estimate)[30].covariance)(0, 0) = none;
    EXPECT_THAT(reason("nees_position_mean"), HasSubstr("positive definite"));
  }
}

TEST_F(Evaluate, NeesOfAFittedEstimateIsComputedAfterAlignmentByTheFirstPose) {
  Eigen::Isometry3d X = upright(1, 2, 3, 0.5);
  Matrix6d P = Matrix6d::Identity();
  P.diagonal().tail<3>() << 4, 1, 1;
  for (files::TumRow& pose : *run.estimate) {
    const double error = pose.t == run.truth_camera[21].t ? 0 : 2;  // along x of W; P has 4 there
    pose.X.translation().x() -= error;
    pose.X = X * pose.X;
    Matrix6d J = Matrix6d::Identity();
    J.bottomRightCorner<3, 3>() = X.linear();
    pose.covariance = J * P * J.transpose();
  }
  EXPECT_GT(value("nees_position_mean"), 3);
  run.fitted = true;
  EXPECT_NEAR(value("nees_position_mean"), 399 / 400.0, 1e-9);
  EXPECT_NEAR(value("nees_orientation_mean"), 0, 1e-9);
}

TEST_F(Evaluate, ErrorsOfOnlySomePosesSaySoAndSim3ErrorsStateTheirScale) {
  EXPECT_EQ(metric("ate_se3_rmse_m").note, std::nullopt);
  EXPECT_EQ(metric("ate_sim3_rmse_m").note, "scale 1");
  for (files::TumRow& pose : *run.estimate) pose.X.translation() /= 8;
  run.estimate->resize(221);
  EXPECT_EQ(metric("ate_se3_rmse_m").note, "200 of 400 true poses");
  EXPECT_THAT(metric("ate_sim3_rmse_m").note.value(), HasSubstr("200 of 400 true poses, scale 8; warning: "));
  for (files::TumRow& pose : *run.estimate) pose.X.translation() *= 8;
  run.scaled_by = 8;
  EXPECT_THAT(metric("ate_sim3_rmse_m").note.value(), HasSubstr("scale 8; warning: ")) << "scaled before";
  run.no_scale = "scaled to the truth", run.fitted = true;
  EXPECT_EQ(reason("rmse_m"), "scaled to the truth");
  EXPECT_GT(value("ate_se3_rmse_m"), 0.1) << "of the path as the estimator gave it";
}

TEST_F(Evaluate, InnovationsCountOnceTheRobotMovesAndWhitenessIsTheirCorrelation) {
  for (int i = 0; i <= 420; ++i)
    run.innovations[1].push_back({milliseconds(100 * i), i <= 20 ? 1000.0 : i % 2 == 0 ? 2.0 : 4.0, 3});
  run.innovations[1].push_back({milliseconds(42100), 99, 0});  // a frame without a reading
  EXPECT_NEAR(value("nis_gyro_mean"), 1, 1e-12);
  EXPECT_EQ(reason("nis_vision_mean"), "the sensor was used in fewer than two frames");
  for (int i = 0; i <= 420; ++i) {  // 2 and -2 alternately
    const double product = i < 20 ? 100 : -4;
    run.innovations[0].push_back({milliseconds(100 * i), 4, 1, product, 4});
  }
  EXPECT_NEAR(value("innovation_lag1_vision"), -1, 1e-12);
  EXPECT_EQ(reason("innovation_lag1_gyro"), "no innovations of consecutive frames were reported");
}

TEST_F(Evaluate, TheShareOfSuccessfulSearchesCountsOnceTheRobotMoves) {
  EXPECT_NE(reason("found_landmarks_fraction"), "");
  for (const auto& [t_ms, searched, found] : {std::tuple(0, 12U, 0U), {20000, 12U, 9U}, {21000, 8U, 6U}}) {
    score::FrameUse& frame = run.use.emplace_back();
    frame.t = milliseconds(t_ms), frame.searched = searched, frame.found = found;
  }
  EXPECT_EQ(value("found_landmarks_fraction"), 0.75);
}

TEST_F(Evaluate, OdometryWithoutImagesAndTheSmoothedEstimateHaveTheirOwnErrors) {
  for (const auto& [member, prefix, why] :
       {std::tuple(&Run::odometry, "odometry_", "did not run"),
        std::tuple(&Run::smoothed, "smoothed_", "nothing was smoothed")}) {
    const std::string ate = std::string(prefix) + "ate_se3_rmse_m";
    EXPECT_THAT(reason(ate), HasSubstr(why));
    for (std::size_t i = 0; i < run.truth_camera.size(); ++i) {
      (run.*member).push_back(run.truth_camera[i]);
      (run.*member).back().X.translation() += Eigen::Vector3d(1, 0, i % 2 == 0 ? 0.1 : -0.1);
    }
    EXPECT_NEAR(value(ate), 0.1, 1e-3);
    move_estimates({1, 0, 0});
    EXPECT_NEAR(value(ate), 0.1, 1e-3) << "whatever the estimate";
  }
  EXPECT_NEAR(value("smoothed_rmse_m"), std::hypot(1, 0.1), 1e-12) << "not aligned";
  EXPECT_EQ(value("smoothed_rotation_rmse_deg"), 0);
}

TEST_F(Evaluate, LandmarksAreComparedWithTheWallsOnWhichTheyWereSeen) {
  const TimedPose& seen_from = run.truth_camera[21];
  const Eigen::Vector2d pixel = *run.camera.project(seen_from.X, Eigen::Vector3d(5, 0, 1.4));
  run.landmarks = {{1, {seen_from.t, pixel}, {}}, {2, {seen_from.t, pixel}, {}}, {3, {Stamp(7), pixel}, {}}};
  for (int id = 1; id <= 4; ++id) run.map.push_back({id, Eigen::Vector3d(5, 0, 1.4 + 0.3 * id)});
  EXPECT_NEAR(value("landmark_rmse_m"), std::sqrt((0.09 + 0.36) / 2), 1e-9)
      << "3 was first seen at an unknown pose, 4 has no history";
  run.surfaces.clear();
  EXPECT_NE(reason("landmark_rmse_m"), "");
}

// From 21 s on, a room of 6 x 6 m moves into the view and hides the walls.
TEST_F(Evaluate, ActorsHaveAShareOfTheImagesAndOfTheLandmarksWhichThenHaveNoPoint) {
  const TimedPose &before = run.truth_camera[21], &after = run.truth_camera[220];
  run.landmarks = {
      {1, {before.t, {100, 120}}, {}}, {2, {after.t, {100, 120}}, {}}, {3, {Stamp(7), {100, 120}}, {}}};
  run.map = {{1, Eigen::Vector3d(5, 0, 1.4)}, {2, Eigen::Vector3d(-50, 0, 0)}};
  EXPECT_GT(value("landmark_rmse_m"), 10);
  for (const char* name : {"moving_image_fraction", "moving_landmarks_fraction"})
    EXPECT_THAT(reason(name), HasSubstr("nothing moves"));
  run.actors = [](Stamp t) {
    const Surface around{Surface::Kind::box, upright(0, 0, 1.4), {3, 3, 1}};
    return t < milliseconds(21000) ? std::vector<Surface>{} : std::vector{around};
  };
  EXPECT_EQ(value("moving_image_fraction"), 21.0 / 40) << "of every tenth frame";
  EXPECT_EQ(value("moving_landmarks_fraction"), 0.5) << "3 was first seen at an unknown pose";
  EXPECT_LT(value("landmark_rmse_m"), 5) << "2 is on an actor";
}

TEST_F(Evaluate, AnErrorAtAnEarlyEndStatesTheTime) {
  EXPECT_EQ(metric("end_position_error_m").note, std::nullopt);
  run.estimate->resize(106);
  EXPECT_EQ(metric("end_position_error_m").note, "at 10.5 s, 25 % of 42.0 s");
  for (const char* name : {"plan_rmse_m", "plan_drift_x_m"}) EXPECT_EQ(metric(name).note, std::nullopt);
  EXPECT_EQ(value("poses_matched"), 85);
  EXPECT_EQ(value("true_poses"), 400);
  run.plan_end = milliseconds(525000);
  EXPECT_EQ(metric("plan_drift_x_m").note, "at 42.0 s, 8 % of 525.0 s");
}

TEST_F(Evaluate, WithoutAScaleOnlyLengthsHaveNoValue) {
  run.no_scale = "the scale is unknown";
  close_loop(3);
  for (const char* name : {"rmse_m", "ate_se3_rmse_m", "rpe_1m_m", "drift_percent", "height_range_m",
                           "scale_error_percent", "nees_position_mean", "loop_error_before_m"})
    EXPECT_EQ(reason(name), "the scale is unknown") << name;
  for (const char* name : {"ate_sim3_rmse_m", "rotation_rmse_deg", "rpe_1m_deg", "nees_orientation_mean",
                           "path_length_m", "loop_landmarks"})
    EXPECT_TRUE(metric(name).value) << name;
}

// A filter with a NEES or NIS far below its expectation is as inconsistent as one far above it.
TEST(MetricDefinitions, HaveTheUnitInTheirNameAndTheDirectionInTheirText) {
  const std::vector<std::pair<std::string, std::string>> units{
      {"_m_s2", "m/s2"}, {"_m", "m"},       {"_deg", "deg"}, {"_s", "s"},
      {"_ms", "ms"},     {"_percent", "%"}, {"", "1"}};
  std::set<std::string_view> names;
  for (const MetricDefinition& d : metric_definitions()) {
    EXPECT_TRUE(names.insert(d.name).second) << d.name;
    EXPECT_GT(d.definition.size(), 20u) << d.name;
    const auto unit =
        std::ranges::find_if(units, [&](const auto& known) { return d.name.ends_with(known.first); });
    EXPECT_EQ(d.unit, unit->second) << d.name;
    const std::string text(d.definition);
    const std::size_t end = text.find(" is expected"), begin = text.rfind("; ", end) + 2;
    const bool expects = end != text.npos;
    EXPECT_EQ(d.direction.worst == Worst::farthest_from_expected, expects) << d.name;
    EXPECT_EQ(expects, d.name.starts_with("nees_") || d.name.starts_with("nis_")) << d.name;
    EXPECT_EQ(d.direction.expected, expects ? std::stod(text.substr(begin)) : 1) << d.name;
  }
  EXPECT_EQ(direction_of("whatever").worst, Worst::largest);
}

}  // namespace
}  // namespace sim::score
