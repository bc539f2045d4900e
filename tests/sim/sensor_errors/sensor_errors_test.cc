#include "sim/sensor_errors/sensor_errors.h"

#include "tests/sim/recording/random_readings.h"

namespace sim::sensor_errors {
namespace {

using slam::Stamp;
using tests::expect_same;

slam::InertialSample reading(std::int64_t begin_us, std::int64_t end_us) {
  return {Stamp(begin_us * 1000), Stamp(end_us * 1000), Eigen::Vector3d(0.1, -0.2, 0.3)};
}

slam::Observation observation(int frame) {
  slam::Observation o;
  o.t = Stamp(33'000'000ll * (frame + 1));
  o.image = cv::Mat(240, 320, CV_8UC1, cv::Scalar(128));
  for (int us = 33000 * frame; us < 33000 * frame + 30000; us += 5000)
    o.gyro.push_back(reading(us, us + 5000));
  o.accelerometer = o.gyro;
  o.plan.emplace();
  return o;
}

// Returns the single observation that arrives.
slam::Observation applied(SensorErrors& errors, const slam::Observation& ideal) {
  std::vector<slam::Observation> arrived = errors.process(ideal);
  EXPECT_EQ(arrived.size(), 1u);
  return arrived.at(0);
}
slam::Observation applied(const ErrorOptions& options, const slam::Observation& ideal,
                          std::uint64_t seed = 1) {
  SensorErrors errors(options, seed);
  return applied(errors, ideal);
}

ErrorOptions none() {
  ErrorOptions options;
  options.gyro.sigma = options.accelerometer.sigma = 0;
  options.image.read_sigma_gray = options.image.shot_sigma_gray = 0;
  return options;
}

TEST(SensorErrors, NoErrorsLeaveTheObservationsUnchanged) {
  SensorErrors errors(none(), 1);
  for (int frame = 0; frame < 5; ++frame)
    expect_same(applied(errors, observation(frame)), observation(frame));
}

TEST(SensorErrors, DependOnSeedAndStampButNotOnEarlierCalls) {
  SensorErrors live(ErrorOptions{}, 7);
  for (int frame = 0; frame < 5; ++frame) applied(live, observation(frame));
  const slam::Observation now = applied(live, observation(5));
  expect_same(now, applied(ErrorOptions{}, observation(5), 7));
  EXPECT_NE(now.gyro[0].value, applied(ErrorOptions{}, observation(5), 8).gyro[0].value);
  EXPECT_NE(now.gyro[0].value, applied(ErrorOptions{}, observation(4), 7).gyro[0].value);
}

TEST(SensorErrors, OneErrorDoesNotShiftTheNumbersOfAnother) {
  ErrorOptions lossy;
  lossy.image.loss_fraction = lossy.plan_loss_fraction = 0.5;
  lossy.accelerometer.sigma = 3;
  for (int frame = 0; frame < 5; ++frame)
    EXPECT_EQ(applied(ErrorOptions{}, observation(frame)).gyro[3].value,
              applied(lossy, observation(frame)).gyro[3].value);
}

// The standard deviation of the gyro's noise over many readings of one length, all axes together.
double gyro_spread(SensorErrors& errors, std::int64_t duration_us) {
  double sum = 0;
  constexpr int n = 20000;
  for (int i = 0; i < n; ++i) {
    slam::Observation o;
    o.gyro.push_back(reading(duration_us * i, duration_us * (i + 1)));
    o.t = o.gyro[0].end;
    sum += (applied(errors, o).gyro[0].value - reading(0, 1).value).squaredNorm();
  }
  return std::sqrt(sum / (3 * n));
}

TEST(SensorErrors, GyroNoiseOfAPartOfAReadingKeepsTheIntegralWhite) {
  SensorErrors errors(ErrorOptions{}, 1);
  // Five standard errors of a standard deviation from 60000 numbers are 1.4 %.
  EXPECT_NEAR(gyro_spread(errors, 5000) / 0.01, 1, 0.015);
  EXPECT_NEAR(gyro_spread(errors, 2000) / (0.01 * std::sqrt(2.5)), 1, 0.015);
}

TEST(SensorErrors, BiasIsConstantOverARunAndDiffersBetweenSeeds) {
  ErrorOptions options = none();
  options.gyro.bias_sigma = 0.01;
  SensorErrors errors(options, 1);
  const Eigen::Vector3d ideal = reading(0, 1).value,
                        bias = applied(errors, observation(0)).gyro[0].value - ideal;
  EXPECT_GT(bias.norm(), 1e-4);
  EXPECT_EQ(applied(errors, observation(9)).gyro[5].value - ideal, bias);
  EXPECT_NE(applied(options, observation(0), 2).gyro[0].value - ideal, bias);
}

TEST(SensorErrors, LossTakesTheFractionAskedForAndOnlyThat) {
  ErrorOptions options = none();
  options.image.loss_fraction = 0.1;
  options.plan_loss_fraction = 0.3;
  SensorErrors errors(options, 1);
  constexpr int n = 2000;
  std::array<int, 4> counts{};  // lost: both, the image, the plan, neither
  for (int frame = 0; frame < n; ++frame) {
    slam::Observation o = observation(frame);
    o.image = cv::Mat(2, 2, CV_8UC1, cv::Scalar(0));
    const slam::Observation out = applied(errors, o);
    ++counts[(out.image.empty() ? 0u : 2u) + (out.plan ? 1u : 0u)];
  }
  for (std::size_t i = 0; const double p : {0.1 * 0.3, 0.1 * 0.7, 0.9 * 0.3, 0.9 * 0.7})
    EXPECT_NEAR(counts[i++], p * n, 5 * std::sqrt(p * (1 - p) * n));
}

TEST(SensorErrors, ABiasWalksAsFarAsRequested) {
  ErrorOptions options = none();
  options.gyro.bias_walk_sigma = 0.01;
  constexpr int kSeeds = 200;
  double after_1_s = 0, after_4_s = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    SensorErrors errors(options, seed);
    for (int frame = 0; frame < 121; ++frame) {
      slam::Observation ideal = observation(frame);
      ideal.image.release();
      const double square = (applied(errors, ideal).gyro[5].value - reading(0, 1).value).squaredNorm();
      if (frame == 30) after_1_s += square / (3 * kSeeds);
      if (frame == 120) after_4_s += square / (3 * kSeeds);
    }
  }
  // 600 numbers: five standard errors of their standard deviation are 14 %. 30 of 33 ms of a frame count.
  EXPECT_NEAR(std::sqrt(after_1_s) / (0.01 * std::sqrt(31 * 0.030)), 1, 0.14);
  EXPECT_NEAR(std::sqrt(after_4_s) / (0.01 * std::sqrt(121 * 0.030)), 1, 0.14);
}

// Returns the observations that arrive from some frames at 33 ms intervals, with only these faults.
std::vector<slam::Observation> arrived_with(std::vector<Fault> faults, int frames) {
  ErrorOptions options = none();
  options.faults = std::move(faults);
  SensorErrors errors(options, 1);
  std::vector<slam::Observation> all;
  for (int frame = 0; frame < frames; ++frame) {
    slam::Observation ideal = observation(frame);
    ideal.image.setTo(frame + 1);
    ideal.plan->X_PC.translation().x() = 0.01 * frame;
    ideal.plan->v_PC_C.z() = 0.3;
    for (slam::Observation& o : errors.process(std::move(ideal))) all.push_back(std::move(o));
  }
  for (slam::Observation& o : errors.flush()) all.push_back(std::move(o));
  return all;
}

template <class Kind>
Kind during(double from_s, double duration_s) {
  Kind fault;
  fault.from_s = from_s;
  fault.duration_s = duration_s;
  return fault;
}

// One character for each arrival: the number of its frame, found by its stamp.
std::string order(const std::vector<slam::Observation>& arrived) {
  std::string frames;
  for (const slam::Observation& o : arrived) frames += char('0' + o.t.count() / 33'000'000 - 1);
  return frames;
}

// The gray level of each image, '-' without one.
std::string pictures(const std::vector<slam::Observation>& arrived) {
  std::string grays;
  for (const slam::Observation& o : arrived)
    grays += o.image.empty() ? '-' : char('0' + o.image.at<unsigned char>(0, 0) - 1);
  return grays;
}

// Frames 3, 4 and 5 are at 0.132, 0.165 and 0.198 s.
constexpr double kFrom = 0.12, kFor = 0.08;

TEST(Faults, LoseAndFreezePicturesButLetTheRestArrive) {
  EXPECT_EQ(pictures(arrived_with({}, 8)), "01234567");
  EXPECT_EQ(pictures(arrived_with({during<FramesLost>(kFrom, kFor)}, 8)), "012---67");
  EXPECT_EQ(pictures(arrived_with({during<FramesFrozen>(kFrom, kFor)}, 8)), "01222267");
  EXPECT_EQ(order(arrived_with({during<FramesLost>(kFrom, kFor)}, 8)), "01234567");
}

TEST(Faults, DoubleAndReorderWhatArrives) {
  EXPECT_EQ(order(arrived_with({during<FramesDoubled>(kFrom, kFor)}, 8)), "01233445567");
  EXPECT_EQ(order(arrived_with({during<FramesReordered>(kFrom, kFor)}, 8)), "01243657");
  EXPECT_EQ(order(arrived_with({during<FramesReordered>(0, 9)}, 5)),
            "10324");  // the last has none to wait for
  const auto doubled = arrived_with({during<FramesDoubled>(kFrom, kFor)}, 8);
  expect_same(doubled[3], doubled[4]);
}

TEST(Faults, IncludeTheirBeginningAndExcludeTheirEnd) {
  const FramesLost fault = during<FramesLost>(0.5, 0.25);
  const Stamp from = stamp(0.5), to = stamp(0.75), ns(1);
  EXPECT_TRUE(!fault.holds(from - ns) && fault.holds(from) && fault.holds(to - ns) && !fault.holds(to));
  const auto touches = [&](Stamp begin, Stamp end) {
    return fault.touches({begin, end, Eigen::Vector3d::Zero()});
  };
  EXPECT_TRUE(!touches(stamp(0.4), from) && touches(stamp(0.4), from + ns));
  EXPECT_TRUE(touches(to - ns, stamp(0.8)) && !touches(to, stamp(0.8)));
}

TEST(Faults, AffectTheRequestedFraction) {
  FramesDoubled some = during<FramesDoubled>(0, 1e6);
  some.fraction = 0.2;
  const double n = 1000, doubled = double(arrived_with({some}, 1000).size()) - n;
  EXPECT_NEAR(doubled, 0.2 * n, 5 * std::sqrt(0.2 * 0.8 * n));
}

TEST(Faults, DimThePicture) {
  FramesDimmed fault = during<FramesDimmed>(kFrom, kFor);
  for (const auto& [factor, gray] : {std::pair(0.0, 0), {10.0, 50}}) {
    fault.factor = factor;
    const auto all = arrived_with({fault}, 8);
    EXPECT_EQ(all[4].image.at<unsigned char>(5, 5), gray);
    EXPECT_EQ(all[6].image.at<unsigned char>(5, 5), 7);
  }
}

TEST(Faults, CoverThePictureWithAStationaryPoster) {
  const auto all = arrived_with({during<FramesCovered>(kFrom, kFor)}, 8);
  EXPECT_EQ(cv::countNonZero(all[2].image != 3), 0);
  const cv::Mat poster = all[3].image != 4;
  EXPECT_NEAR(cv::countNonZero(poster) / (240.0 * 320), 0.3, 0.005);  // sides are whole pixels
  cv::Mat difference;
  cv::bitwise_and(all[3].image != all[4].image, poster, difference);
  EXPECT_EQ(cv::countNonZero(difference), 0);
  cv::Scalar mean, sd;
  cv::meanStdDev(all[3].image, mean, sd, poster);
  EXPECT_GT(sd[0], 20);  // textured: landmarks would be found on it
}

TEST(Faults, SilenceSpikeAndFactorAffectOnlyOneInertialSensor) {
  const auto silent = arrived_with({during<GyroSilent>(kFrom, kFor)}, 8);
  EXPECT_EQ(silent[2].gyro.size(), 6u);
  EXPECT_LT(silent[3].gyro.size(), 6u);
  EXPECT_TRUE(silent[4].gyro.empty());
  EXPECT_EQ(silent[4].accelerometer.size(), 6u);
  GyroScaled reversed = during<GyroScaled>(kFrom, kFor);
  reversed.factor = -1;
  const auto turned = arrived_with({reversed}, 8);
  EXPECT_EQ(turned[2].gyro[0].value, observation(2).gyro[0].value);
  EXPECT_EQ(turned[4].gyro[0].value, -observation(4).gyro[0].value);
  AccelerometerSpike spike;
  spike.from_s = 0.121;
  const auto hit = arrived_with({spike}, 8);
  int readings = 0;
  for (const slam::Observation& o : hit)
    for (const slam::InertialSample& s : o.accelerometer)
      if (s.value != reading(0, 1).value) {
        ++readings;
        EXPECT_LT((s.value - reading(0, 1).value - Eigen::Vector3d::Constant(100)).norm(), 1e-12);
      }
  EXPECT_EQ(readings, 2);  // 5 ms, starting in the middle of a reading
  EXPECT_EQ(hit[4].gyro[5].value, observation(4).gyro[5].value);
}

TEST(Faults, MakeThePlannedPathPermanentlyAndThePlannedVelocityTemporarilyWrong) {
  PlanScaled longer = during<PlanScaled>(kFrom, kFor);
  longer.factor = 1.5;
  const auto all = arrived_with({longer}, 8);
  const auto x = [&](std::size_t i) { return all[i].plan->X_PC.translation().x(); };
  EXPECT_NEAR(x(2), 0.02, 1e-15);
  EXPECT_NEAR(x(5), 0.02 + 1.5 * 0.03, 1e-15);
  EXPECT_NEAR(x(7), 0.07 + 0.015, 1e-15);
  EXPECT_NEAR(all[5].plan->v_PC_C.z(), 0.45, 1e-15);
  EXPECT_NEAR(all[6].plan->v_PC_C.z(), 0.3, 1e-15);
  const auto missing = arrived_with({during<PlanMissing>(kFrom, kFor)}, 8);
  EXPECT_TRUE(missing[2].plan && !missing[3].plan && !missing[5].plan && missing[6].plan);
}

TEST(SensorErrors, ALatePictureArrivesWithALaterFrame) {
  ErrorOptions options = none();
  options.image.latency_s = 0.04;
  SensorErrors errors(options, 1);
  std::string grays;
  for (int frame = 0; frame < 5; ++frame) {
    slam::Observation ideal = observation(frame);
    ideal.image.setTo(frame + 1);
    grays += pictures({applied(errors, ideal)});
  }
  EXPECT_EQ(grays, "--012");
}

/// The position of a camera that moves 0.01 m per frame along x, starting at 5 m.
Eigen::Vector3d position(SensorErrors& errors, int k) {
  slam::Observation o;
  o.t = slam::Stamp(k * 33'333'333LL);
  o.legs.emplace().X_OC.translation().x() = 5 + 0.01 * k;
  return applied(errors, o).legs->X_OC.translation();
}

SensorErrors leg_errors(double sigma_m, double scale_fraction, std::uint64_t seed) {
  ErrorOptions options;
  options.leg_odometry = {sigma_m, scale_fraction};
  return {options, seed};
}

// Within four standard deviations for that many numbers.
TEST(LegErrors, PositionNoiseIsWhiteOfTheRequestedSizeAndDependsOnTheSeed) {
  constexpr double n = 4000, variance = 1e-8;
  SensorErrors errors = leg_errors(1e-4, 0, 1), other = leg_errors(1e-4, 0, 2);
  Eigen::Array3d square = Eigen::Array3d::Zero(), neighbors = square, before = square;
  for (int k = 0; k < n; ++k) {
    const Eigen::Array3d error = position(errors, k) - Eigen::Vector3d(5 + 0.01 * k, 0, 0);
    square += error.square() / n;
    neighbors += error * std::exchange(before, error) / n;
  }
  EXPECT_TRUE(((square - variance).abs() < 4 * variance * std::sqrt(2 / n)).all()) << square.transpose();
  EXPECT_TRUE((neighbors.abs() < 4 * variance / std::sqrt(n)).all()) << neighbors.transpose();
  EXPECT_NE(position(errors, 7), position(other, 7));
}

TEST(LegErrors, DistancesFromTheFirstPositionAreScaledAndZeroErrorsChangeNoBit) {
  SensorErrors errors = leg_errors(0, 0.2, 1), none = leg_errors(0, 0, 1);
  EXPECT_EQ(position(errors, 0).x(), 5);
  EXPECT_NEAR(position(errors, 50).x(), 5.6, 1e-12);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(position(none, k), Eigen::Vector3d(5 + 0.01 * k, 0, 0));
}

using slam::Observation;

constexpr std::int64_t kMs = 1'000'000;

// Frame k at 30 k ms. The readings, every 5 ms, contain the time when they were taken, and so does the plan.
Observation observed(int k) {
  Observation o;
  o.t = Stamp(30 * kMs * k);
  for (int i = 6 * (k - 1); k > 0 && i < 6 * k; ++i)
    o.gyro.push_back({Stamp(5 * kMs * i), Stamp(5 * kMs * (i + 1)), Eigen::Vector3d::Constant(5 * i + 2.5)});
  o.accelerometer = o.gyro;
  for (const slam::InertialSample& reading : o.gyro)
    o.body.push_back(
        {reading.begin, Eigen::VectorXd::Constant(1, 1e3 * slam::seconds(reading.begin)), {}, {}});
  o.plan.emplace();
  o.plan->X_PC.translation().x() = 30 * k;
  o.plan->X_PC.linear() = Eigen::AngleAxisd(0.03 * k, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  o.plan->v_PC_C.y() = 30 * k;
  o.legs.emplace().X_OC.translation().y() = 30 * k;
  o.legs->p_CS.z() = 30 * k;
  o.legs->X_CG.emplace(Eigen::Translation3d(30.0 * k, 0, 0));
  o.command.emplace().t = o.t - Stamp(kMs);
  return o;
}

/// All frames after a clock with that offset. without_plan: the frame that loses its plan on the way.
std::vector<Observation> through(Stamp offset, int frames, int without_plan = -1) {
  MotionClock clock(offset);
  std::vector<Observation> all;
  for (int k = 0; k < frames; ++k) {
    Observation ideal = observed(k);
    if (k == without_plan) ideal.plan.reset();
    for (Observation& o : clock.process(std::move(ideal))) all.push_back(std::move(o));
  }
  for (Observation& o : clock.flush()) all.push_back(std::move(o));
  return all;
}

// Readings lie within their frame and leave no gap. Like the plan, they were taken `offset` before their
// stamps.
TEST(MotionClock, AClockAheadOrBehindGivesEachFrameTheMotionOfAnotherTime) {
  for (const double offset_ms : {7.0, -7.0, 40.0, -40.0}) {
    const auto all = through(Stamp(std::int64_t(offset_ms * 1e6)), 8);
    ASSERT_EQ(all.size(), 8u);
    for (int k = 3; k < 6; ++k) {  // the first and last frames lack the readings before and after the run
      const Observation& o = all[std::size_t(k)];
      ASSERT_EQ(o.t, observed(k).t);
      Stamp begin = o.t - Stamp(30 * kMs);
      for (const slam::InertialSample& reading : o.gyro) {
        EXPECT_EQ(reading.begin, std::exchange(begin, reading.end));
        const double middle_ms = 1e3 * slam::seconds(reading.begin + reading.end) / 2;
        EXPECT_NEAR(reading.value.x(), middle_ms - offset_ms, 2.5);  // half a reading, if it was split
      }
      EXPECT_EQ(begin, o.t);
      EXPECT_EQ(o.accelerometer.size(), o.gyro.size());
      ASSERT_EQ(o.body.size(), 6u);
      for (const slam::BodyReading& reading : o.body) {
        EXPECT_TRUE(reading.t >= o.t - Stamp(30 * kMs) && reading.t < o.t);
        EXPECT_NEAR(1e3 * slam::seconds(reading.t) - offset_ms, reading.q[0], 1e-6);
      }
      const double planned_ms = 30.0 * k - offset_ms;
      const slam::PlannedMotion& plan = *o.plan;
      for (const double ms :
           {plan.X_PC.translation().x(), plan.v_PC_C.y(), o.legs->X_OC.translation().y(), o.legs->p_CS.z(),
            o.legs->X_CG->translation().x(), 1e3 * Eigen::AngleAxisd(plan.X_PC.linear()).angle()})
        EXPECT_NEAR(ms, planned_ms, 1e-6);
      const double given_ms = 1e3 * slam::seconds(o.command->t) - offset_ms;  // one before the frame's motion
      EXPECT_TRUE(given_ms <= planned_ms - 1 + 1e-6 && given_ms > planned_ms - 31) << given_ms;
    }
  }
}

TEST(MotionClock, GivesNoPlanNextToAMissingOneButStillLegOdometry) {
  const auto all = through(Stamp(7 * kMs), 6, 3);
  EXPECT_TRUE(all[2].plan && !all[3].plan && !all[4].plan && all[5].plan);
  EXPECT_TRUE(all[3].legs && all[4].legs && all[3].command);
}

}  // namespace
}  // namespace sim::sensor_errors
