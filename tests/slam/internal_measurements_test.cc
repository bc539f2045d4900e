#include "slam/internal_measurements.h"

#include "tests/slam/synthetic_room.h"

namespace slam {
namespace {

/// A filter without vision on a synthetic walk, at its frame 59.
struct Walking {
  explicit Walking(const Options& o = {}, int frames = 60, bool level = true)
      : options(o), calibration(synthetic::calibration()) {
    calibration.level_floor = level;
    internal.emplace(options, calibration);
    for (int k = 0; k < frames; ++k) step(recording.observation(k));
  }
  void step(const Observation& o) {
    const auto planned = internal->advance_plan(o, now ? seconds(o.t - *now) : 0);
    if (now) {
      report = {};
      predicted = internal->predict(o, *now, planned, kalman.state(), report);
      kalman.predict(predicted.x, predicted.F, predicted.Q);
      before = kalman.state().P().diagonal();
      updated = internal->update(o, *now, planned, kalman, report);
    }
    now = o.t;
  }
  Observation next() const { return recording.observation(60); }
  bool accelerometer_rejected() const { return report.refused.text() == "accelerometer is beyond its gate"; }
  double velocity_noise() const { return predicted.Q(kVelocity, kVelocity); }

  Options options;
  synthetic::Recording recording{synthetic::Walk{}};
  Kalman kalman{initial_state(synthetic::Walk{}.X_WC(0), options),
                options.consistency.observability_constrained};
  Calibration calibration;
  std::optional<InternalMeasurements> internal;
  std::optional<Stamp> now;
  Prediction predicted;
  Eigen::VectorXd before;  // variances before the last update
  FrameReport report;
  bool updated = false;
};

/// The largest variance of the orientation, rad².
double pose_sigma2(const State& state) {
  Eigen::Vector4d inverse = state.orientation();
  inverse.tail<3>() *= -1;
  const Eigen::Matrix<double, 3, 4> J = 2 * left_matrix(inverse).bottomRows<3>();
  return (J * state.P().block<4, 4>(kOrientation, kOrientation) * J.transpose()).diagonal().maxCoeff();
}

TEST(InternalMeasurements, IncludeGyroVelocityAndHeightAndReduceTheUncertainty) {
  Options options;
  options.gyro.drives_motion = false;
  Walking walk(options);
  walk.step(walk.next());
  EXPECT_TRUE(walk.updated);
  EXPECT_FALSE(walk.report.refused);
  for (const auto& [sensor, dof] : {std::pair{"gyro", 3}, {"plan_velocity", 3}, {"height", 1}}) {
    ASSERT_TRUE(nis_of(walk.report.innovations, sensor)) << sensor;
    EXPECT_EQ(nis_of(walk.report.innovations, sensor)->dof, dof) << sensor;
  }
  const Eigen::VectorXd after = walk.kalman.state().P().diagonal();
  for (const int at : {kRate, kVelocity, kVelocity + 1, kPosition + 2})
    EXPECT_LT(after(at), walk.before(at)) << at;
}

TEST(InternalMeasurements, AGyroThatDrivesTheMotionIsNotAMeasurementUnlessItsRateIsImplausible) {
  Walking walk;
  walk.step(walk.next());
  EXPECT_FALSE(nis_of(walk.report.innovations, "gyro"));
  EXPECT_EQ(walk.predicted.F(kRate, kRate), 0);
  Observation o = walk.next();
  o.t += std::chrono::milliseconds(33);
  for (InertialSample& reading : o.gyro) {
    reading.begin += std::chrono::milliseconds(33), reading.end += std::chrono::milliseconds(33);
    reading.value.setConstant(5);
  }
  walk.step(o);
  EXPECT_TRUE(nis_of(walk.report.innovations, "gyro"));
  EXPECT_EQ(walk.predicted.F(kRate, kRate), 1);
}

// The gate is the chi-square quantile of 3 rows, 16.27, times the variance of the change of rate.
TEST(InternalMeasurements, AfterAGapTheGyroDrivesTheMotionOnlyIfTheChangeOfRateIsWithinItsGate) {
  for (const auto& [part, drives] : {std::pair(0.95, true), {1.05, false}}) {
    Walking walk;
    Observation o = walk.next();
    const RobotVector x = walk.kalman.state().robot();
    const double sigma = walk.options.motion.sigma_angular_acceleration_rad_s2 * seconds(o.t - *walk.now);
    const Eigen::Vector3d change = part * std::sqrt(16.27) * sigma * Eigen::Vector3d(1, 2, -2) / 3;
    const Eigen::Vector3d w_C = x.segment<3>(kGyroBias) + x.segment<3>(kRate) + change;
    for (InertialSample& reading : o.gyro)
      reading.value = synthetic::calibration().X_CG.linear().transpose() * w_C;
    o.gyro.front().begin += std::chrono::milliseconds(1);
    walk.step(o);
    EXPECT_EQ(walk.predicted.F(kRate, kRate), drives ? 0 : 1) << part;
  }
}

/// The rate about the camera's y axis at a frame, if encoders read these angles between camera and IMU at
/// that frame and at the previous one, which is the first frame with such readings.
double rate_of_head(double before_rad, double now_rad, bool by_encoders = true) {
  Options options;
  options.leg_odometry.enabled = by_encoders;
  Walking walk(options);
  for (const auto& [k, angle] : {std::pair(60, before_rad), std::pair(61, now_rad)}) {
    Observation o = walk.recording.observation(k);
    const Eigen::AngleAxisd turn(angle, Eigen::Vector3d::UnitY());
    o.legs = LegMotion{o.plan->X_PC, o.plan->p_CF, turn * synthetic::calibration().X_CG};
    walk.step(o);
  }
  return walk.predicted.x(kRate + 1);
}

TEST(InternalMeasurements, TheHeadsRateCombinesTheGyroInTheBodyWithTheEncodersOfTheNeck) {
  const double still = rate_of_head(0.02, 0.02);
  EXPECT_NEAR(rate_of_head(0, 0), still, 1e-3);
  EXPECT_NEAR(rate_of_head(0.02, 0.025), still - 0.005 / seconds(synthetic::Walk{}.stamp(1)), 1e-3);
  EXPECT_EQ(rate_of_head(0.02, 0.025, false), rate_of_head(0, 0, false));
}

TEST(InternalMeasurements, InnovationsAreMultipliedByThoseOfTheLastFrame) {
  Walking walk;
  const Nis first = *nis_of(walk.report.innovations, "height");
  walk.step(walk.next());
  const Nis next = *nis_of(walk.report.innovations, "height");
  EXPECT_NEAR(std::abs(next.lagged), std::sqrt(first.value * next.value), 1e-9);
  EXPECT_EQ(next.lagged_square, next.value);
}

TEST(InternalMeasurements, ReportWhetherEachSensorHadReadingsAndWhetherTheyWereUsed) {
  const auto use = [](const Walking& walk, SensorIndex sensor) {
    return walk.report.use[static_cast<std::size_t>(sensor)];
  };
  using enum SensorIndex;
  Walking walk;
  EXPECT_EQ(use(walk, gyro), SensorUse::accepted);
  EXPECT_EQ(use(walk, height), SensorUse::accepted);
  Observation o = walk.next();
  for (InertialSample& reading : o.gyro) reading.value.setConstant(5);
  o.plan.reset();
  walk.step(o);
  EXPECT_EQ(use(walk, gyro), SensorUse::readings);
  EXPECT_EQ(use(walk, height), SensorUse::none);
  o.t += std::chrono::milliseconds(33);
  o.gyro.clear();
  walk.step(o);
  EXPECT_EQ(walk.report.refused.text(), "the gyro is silent");
  EXPECT_TRUE(walk.report.innovations.empty());
}

/// The next frames of a walk without a plan; gyro and accelerometer change evenly, far beyond the motion
/// model.
void stumble(Walking& walk, int frames, double per_s_rad_s = 60, double per_s_m_s2 = 600) {
  const Stamp begin = *walk.now;
  for (int k = 60; k < 60 + frames; ++k) {
    Observation o = walk.recording.observation(k);
    o.plan.reset();
    for (InertialSample& reading : o.gyro) reading.value.x() += per_s_rad_s * seconds(reading.end - begin);
    for (InertialSample& reading : o.accelerometer)
      reading.value.y() += per_s_m_s2 * seconds(reading.end - begin);
    walk.step(o);
  }
}

TEST(InternalMeasurements, AFastMotionIsNotMistakenForAFault) {
  Walking walk;
  stumble(walk, 5);
  EXPECT_FALSE(walk.report.refused) << walk.report.refused.text();
  EXPECT_EQ(walk.predicted.F(kRate, kRate), 0);
  EXPECT_GT(walk.kalman.state().robot().segment<3>(kRate).norm(), 7);
  Walking jumps;
  jumps.step(jumps.next());
  Observation o = jumps.recording.observation(61);
  o.plan.reset();
  for (InertialSample& reading : o.gyro) reading.value.x() += 7;
  for (InertialSample& reading : o.accelerometer) reading.value.y() -= 150;
  jumps.step(o);
  EXPECT_EQ(jumps.report.refused.text(), "accelerometer is beyond its gate; gyro is beyond its gate");
}

TEST(InternalMeasurements, LegsThatStumbleCountLessForAWhileAndTheirHeightStartsAnew) {
  Walking walk({}, 60, false);
  const auto step = [&](int k, double stumbled_m) {
    Observation o = walk.recording.observation(k);
    o.legs = LegMotion{o.plan->X_PC, o.plan->p_CF};
    o.plan.reset();
    o.legs->X_OC.translation() += Eigen::Vector3d(stumbled_m, 0, stumbled_m > 0 ? 0.2 : 0);
    walk.step(o);
    return std::pair{nis_of(walk.report.innovations, "plan_velocity"),
                     nis_of(walk.report.innovations, "height")};
  };
  step(60, 0);
  const double first = step(61, 0.3).first->value;
  EXPECT_EQ(walk.report.refused.text(), "leg odometry is beyond its gate; height is beyond its gate");
  const auto [velocity, height] = step(62, 0.6);
  EXPECT_LT(velocity->value, 0.1 * first);
  EXPECT_LT(height->value, 10.83);
}

TEST(InternalMeasurements, WithoutTheGyroTheLegsMeasureTheRotation) {
  double error_rad[2];
  for (const bool has_legs : {false, true}) {
    Walking walk;
    for (int k = 60; k < 105; ++k) {
      Observation o = walk.recording.observation(k);
      const synthetic::Walk& truth = walk.recording.walk();
      const Eigen::Isometry3d X_WC = truth.X_WC(seconds(truth.stamp(k)));
      if (has_legs) o.legs = LegMotion{X_WC, o.plan->p_CF};
      o.gyro.clear(), o.accelerometer.clear();
      walk.step(o);
      const Eigen::Matrix3d R_WC = rotation_matrix(walk.kalman.state().orientation());
      error_rad[has_legs] = Eigen::AngleAxisd(R_WC.transpose() * X_WC.linear()).angle();
    }
    const double sigma = std::sqrt(pose_sigma2(walk.kalman.state()));
    EXPECT_EQ(sigma < 0.03, has_legs) << sigma;
  }
  EXPECT_LT(error_rad[1], 0.01);
  EXPECT_GT(error_rad[0], error_rad[1]);
}

TEST(InternalMeasurements, OnAFloorThatIsNotLevelTheVelocityByTheLegsCountsLessTheVerticalOneLeast) {
  const auto sigma = [](bool level, bool has_plan) {
    Walking walk({}, 60, level);
    for (int k = 60; k < 65; ++k) {
      Observation o = walk.recording.observation(k);
      o.legs = LegMotion{o.plan->X_PC, o.plan->p_CF};
      if (!has_plan) o.plan.reset();
      o.accelerometer.clear();
      walk.step(o);
    }
    return Eigen::Array3d(walk.kalman.state().P().diagonal().segment<3>(kVelocity).array().sqrt());
  };
  const Eigen::Array3d level = sigma(true, true), slope = sigma(false, true), no_plan = sigma(false, false);
  EXPECT_TRUE((slope > Eigen::Array3d(1.2, 1.2, 1.3) * level).all()) << (slope / level).transpose();
  EXPECT_GT(no_plan.z(), 1.3 * slope.z());
}

TEST(InternalMeasurements, LegsThatYieldInAStepDoNotContradictThePlannedHeight) {
  const auto refused = [](double yields_m) {
    Walking walk;
    Observation o = walk.next();
    o.plan->X_PC.translation().z() += yields_m;
    walk.step(o);
    return walk.report.refused.text();
  };
  EXPECT_EQ(refused(0.002), "");
  EXPECT_NE(refused(0.03).find("height is beyond its gate"), std::string::npos);
}

/// The scale of a plan, found in a walk of 7 s with leg odometry, a step every 0.8 s, and the speed at its
/// end.
struct PlanByLegs {
  double error, sigma, speed_m_s;
};
PlanByLegs plan_by_legs(double scale, bool level = true) {
  Walking walk({}, 0, level);
  SystematicEvidence sum;
  for (int k = 0; k < 210; ++k) {
    Observation o = walk.recording.observation(k);
    o.plan->support = k / 24 % 2 == 0 ? Support::left : Support::right;
    o.legs = LegMotion{o.plan->X_PC, o.plan->p_CF};
    o.plan->X_PC.translation().head<2>() *= scale;
    walk.step(o);
    const SystematicEvidence evidence = walk.kalman.release_evidence()[kPlanScale];
    sum.score += evidence.score, sum.information += evidence.information;
  }
  return {sum.score / sum.information, 1 / std::sqrt(sum.information),
          walk.kalman.state().robot().segment<3>(kVelocity).norm()};
}

TEST(InternalMeasurements, LegOdometryReplacesThePlanButThePlanIsStillTested) {
  const PlanByLegs right = plan_by_legs(1), wrong = plan_by_legs(1.2);
  EXPECT_NEAR(right.error, 0, 1e-12);
  EXPECT_NEAR(wrong.error, 0.2, 1e-12);
  EXPECT_LT(wrong.sigma, 0.03);
  EXPECT_NEAR(wrong.speed_m_s, right.speed_m_s, 0.01 * right.speed_m_s);
}

TEST(InternalMeasurements, OnAFloorThatIsNotLevelThePlanIsTestedLessStrictly) {
  const PlanByLegs level = plan_by_legs(1.2), slope = plan_by_legs(1.2, false);
  EXPECT_NEAR(slope.error, 0.2, 1e-12);
  EXPECT_NEAR(slope.sigma, 6 * level.sigma, 1e-9);
}

/// The gyro's bias about x (truly 0.02 rad/s) and its sigma, after a second at rest or of walking.
struct FoundBias {
  double mean, sigma;
};
FoundBias bias_after_a_second(const Options& options, bool at_rest) {
  Walking walk(options, 0);
  const Eigen::Vector3d bias = synthetic::calibration().X_CG.linear().transpose().col(0) * 0.02;
  const int begin = at_rest ? 0 : 30;  // the recorded robot stands for half a second
  for (int k = begin; k < begin + 30; ++k) {
    Observation o = walk.recording.observation(k);
    if (at_rest) o.plan = walk.recording.observation(0).plan;
    for (InertialSample& reading : o.gyro)
      reading.value = bias + (at_rest ? Eigen::Vector3d(0, 0, 0) : reading.value);
    o.accelerometer.clear();
    walk.step(o);
  }
  const State& state = walk.kalman.state();
  return {state.robot()(kGyroBias), std::sqrt(state.storage_P(kGyroBias, kGyroBias))};
}

TEST(InternalMeasurements, StandingStillAtTheStartRevealsTheBiasOfTheGyro) {
  Options options;
  const FoundBias rest = bias_after_a_second(options, true), walking = bias_after_a_second(options, false);
  EXPECT_NEAR(rest.mean, 0.02, 0.002);
  EXPECT_LT(rest.sigma, 0.35 * options.gyro.sigma_bias_rad_s);
  EXPECT_GT(walking.sigma, 0.9 * options.gyro.sigma_bias_rad_s);
  options.start.sigma_rest_rad_s = 0;
  EXPECT_GT(bias_after_a_second(options, true).sigma, 0.9 * options.gyro.sigma_bias_rad_s);
}

TEST(InternalMeasurements, TheAccelerometerMakesThePredictionCertainAndASpikeIsRejected) {
  Options without;
  without.accelerometer.enabled = false;
  Walking with_it, without_it(without), spiked;
  with_it.step(with_it.next());
  without_it.step(without_it.next());
  EXPECT_FALSE(with_it.accelerometer_rejected());
  EXPECT_LT(with_it.velocity_noise(), 0.01 * without_it.velocity_noise());
  Observation o = spiked.next();
  o.accelerometer[2].value.y() += 500;
  spiked.step(o);
  EXPECT_TRUE(spiked.accelerometer_rejected());
  EXPECT_EQ(spiked.velocity_noise(), without_it.velocity_noise());
}

TEST(InternalMeasurements, AnAccelerometerThatContradictsThePlanIsRejected) {
  Walking walk;
  Observation o = walk.next();
  for (InertialSample& sample : o.accelerometer) sample.value.z() += 6;  // m/s²: only the plan contradicts it
  walk.step(o);
  EXPECT_TRUE(walk.accelerometer_rejected());
  Options no_plan;
  no_plan.plan_velocity.enabled = false;
  Walking alone(no_plan);
  alone.step(o);
  EXPECT_FALSE(alone.accelerometer_rejected());
}

TEST(InternalMeasurements, RejectsASpikeOfTheGyroAndUpdatesWithTheRest) {
  Walking walk;
  Observation o = walk.next();
  o.gyro[2].value.x() += 40;
  o.accelerometer.clear();
  walk.step(o);
  EXPECT_EQ(walk.report.refused.text(), "gyro is beyond its gate");
  EXPECT_GT(nis_of(walk.report.innovations, "gyro")->value, 16.27);  // chi-square, 99.9 %, 3 rows
  EXPECT_TRUE(nis_of(walk.report.innovations, "plan_velocity"));
  EXPECT_TRUE(walk.updated);
}

}  // namespace
}  // namespace slam
