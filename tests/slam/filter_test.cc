#include "slam/filter.h"

#include "tests/slam/synthetic_room.h"

namespace slam {
namespace {

/// A walk with a few steps and some turning, rendered once per process.
const synthetic::Recording& short_walk() {
  static const synthetic::Recording recording = synthetic::recorded(3.5, 0.1);
  return recording;
}

Filter filter_at_start(const Options& options, std::uint64_t seed = 1) {
  return {options, synthetic::calibration(), short_walk().walk().X_WC(0), seed};
}

using Spoil = std::function<void(Observation&)>;

/// Steps through the frames [from, to) of the short walk, each spoiled first. Returns the last report.
FrameReport step(
    Filter& filter, int from, int to, const Spoil& spoil = [](Observation&) {}) {
  FrameReport report;
  for (int k = from; k < to; ++k) {
    Observation o = short_walk().observation(k);
    spoil(o);
    report = filter.step(o);
  }
  return report;
}

void lose_image(Observation& o) { o.image = cv::Mat(); }

struct Errors {
  // least_heading_rad: minimum of the heading's standard deviation.
  double rms_m = 0, sigma_end_m = 0, nees_position = 0, least_heading_rad = 1e9;
  int accepted = 0, lost = 0;  // lost: frames with a health that is not ok
  bool valid = true;           // the covariance is finite and symmetric
  bool sound() const { return valid && lost == 0; }
};

/// The errors of a filter over the short walk.
Errors walk(const Options& options, std::uint64_t seed = 1) {
  const synthetic::Recording& recording = short_walk();
  Filter filter = filter_at_start(options, seed);
  Errors e;
  const int frames = recording.walk().frames();
  for (int k = 0; k < frames; ++k) {
    const FrameReport& report = filter.step(recording.observation(k));
    e.accepted += report.accepted;
    const Matrix6d& P = filter.estimate().covariance;
    const Eigen::Isometry3d X_WC = recording.walk().X_WC(seconds(recording.walk().stamp(k)));
    const Eigen::Vector3d error = X_WC.translation() - filter.estimate().X_WC.translation();
    e.rms_m += error.squaredNorm() / frames;
    e.nees_position += error.dot(P.bottomRightCorner<3, 3>().llt().solve(error)) / frames;
    e.sigma_end_m = std::sqrt(P.bottomRightCorner<3, 3>().trace());
    const Eigen::Vector3d up_C = filter.estimate().X_WC.linear().transpose().col(2);
    e.least_heading_rad = std::min(e.least_heading_rad, std::sqrt(up_C.dot(P.topLeftCorner<3, 3>() * up_C)));
    e.lost += report.health == Health::ok ? 0 : 1;
    e.valid = e.valid && P.allFinite() && P == P.transpose();
  }
  e.rms_m = std::sqrt(e.rms_m);
  return e;
}

const Errors& default_walk() {
  static const Errors errors = walk(Options{});
  return errors;
}

Options vision_only() {
  Options options;
  options.gyro.enabled = options.accelerometer.enabled = false;
  options.plan_velocity.enabled = options.height.enabled = false;
  return options;
}

TEST(Filter, FollowsAShortWalkWithinItsUncertaintyAndTheHeadingsNeverFallsBelowTheInitialOne) {
  const Errors& e = default_walk();
  EXPECT_TRUE(e.sound());
  EXPECT_LT(e.rms_m, 0.02);  // the plan is off by 3 % of 0.7 m of path and by its excess turn
  double nees_position = e.nees_position;
  for (const std::uint64_t seed : {2U, 3U}) nees_position += walk({}, seed).nees_position;
  EXPECT_LT(nees_position / 3, 8);  // 3 expected; the errors of one walk are correlated
  EXPECT_GT(e.accepted, 5 * short_walk().walk().frames());
  // 1 %: heading is slightly correlated with tilt, which gravity reveals
  EXPECT_GT(e.least_heading_rad, 0.99 * Options{}.start.sigma_orientation_rad);
}

TEST(Filter, SmoothedPosesCoverTheRecordedStepsAndEndAtItsEstimate) {
  Filter filter = filter_at_start({});
  EXPECT_FALSE(filter.smoothed());
  filter.record();
  step(filter, 0, 30);
  filter.step(short_walk().observation(29));  // rejected: its time is not later than the last one
  const auto poses = filter.smoothed();
  ASSERT_TRUE(poses && poses->size() == 30);
  EXPECT_EQ(poses->back().t, filter.estimate().t);
  EXPECT_TRUE(poses->back().X_WC.isApprox(filter.estimate().X_WC, 1e-12));
}

TEST(Filter, ItsUncertaintyIsLargerWithoutSensorsOfScaleOrWithoutVision) {
  // Without any measurement of the scale, its error is random, but the filter must state that
  // uncertainty.
  Options blind;
  blind.vision.enabled = false;
  const Errors only_vision = walk(vision_only()), without = walk(blind);
  const auto added_m = [](const Errors& e) {  // to the uncertainty of the start, which all walks share
    return std::sqrt(e.sigma_end_m * e.sigma_end_m - 3 * std::pow(Options{}.start.sigma_position_m, 2));
  };
  EXPECT_GT(only_vision.rms_m, default_walk().rms_m);
  EXPECT_GT(added_m(only_vision), 3 * added_m(default_walk()));
  EXPECT_TRUE(without.sound());
  EXPECT_EQ(without.accepted, 0);
  EXPECT_GT(without.sigma_end_m, default_walk().sigma_end_m);
}

/// The output of a filter, in bits that can be compared.
std::vector<double> fingerprint(const Filter& filter) {
  std::vector<double> bits;
  const auto add = [&](const auto& matrix) {
    bits.insert(bits.end(), matrix.data(), matrix.data() + matrix.size());
  };
  add(filter.estimate().X_WC.matrix());
  add(filter.estimate().covariance);
  for (const MapPoint& p : filter.map()) add(p.p_W), add(p.covariance);
  return bits;
}

TEST(Filter, ContinuesByPlanOrLegOdometryUntilAnImageHasCorners) {
  Options options;
  options.tracking.lost_after_s = 1;
  for (const bool knows_motion : {true, false}) {
    Filter filter = filter_at_start(options);
    for (int k = 0; k < 45; ++k) {
      Observation o = short_walk().observation(k);
      for (int column = 0; column < o.image.cols; ++column)  // stripes that move
        o.image.col(column).setTo((column + k) / 8 % 2 == 0 ? 60 : 180);
      if (knows_motion && k % 2 == 0) o.legs = LegMotion{o.plan->X_PC, o.plan->p_CF};
      if (!knows_motion) o.plan.reset();
      filter.step(o);
    }
    const FrameReport& report = filter.step(short_walk().observation(45));
    EXPECT_EQ(report.health, knows_motion ? Health::ok : Health::lost);
    EXPECT_EQ(report.landmarks > 0, knows_motion);
  }
}

TEST(Filter, WithoutAPlanTheStartIsMoreUncertain) {
  for (const bool has_plan : {true, false}) {
    Filter filter = filter_at_start({});
    Observation o = short_walk().observation(0);
    o.legs = LegMotion{o.plan->X_PC, o.plan->p_CF};
    if (!has_plan) o.plan.reset();
    filter.step(o);
    const Vector6d sigma = filter.estimate().covariance.diagonal().cwiseSqrt();
    EXPECT_NEAR(sigma[3], has_plan ? Options{}.start.sigma_position_m : 0.003, 1e-9);
    EXPECT_NEAR(sigma[5], has_plan ? Options{}.start.sigma_position_m : 0.01, 1e-9);
  }
}

/// The height of a filter after a walk in which leg odometry climbs at 50 mm/s, and whether the height was
/// suspect.
std::pair<double, bool> height_after_climbing(bool level) {
  Calibration calibration = synthetic::calibration();
  calibration.level_floor = level;
  Options options;
  options.vision.enabled = options.accelerometer.enabled = false;
  Filter filter(options, calibration, short_walk().walk().X_WC(0), 1);
  bool suspect = false;
  for (int k = 0; k < short_walk().walk().frames(); ++k) {
    Observation o = short_walk().observation(k);
    o.legs = LegMotion{o.plan->X_PC, o.plan->p_CF};
    o.legs->X_OC.translation().z() += 0.05 * std::max(0, k - 30) / 30;
    suspect = suspect || filter.step(o).suspect == "inconsistent: height, the floor is not level";
  }
  return {filter.estimate().X_WC.translation().z() - short_walk().walk().X_WC(0).translation().z(), suspect};
}

TEST(Filter, ClimbsIfTheFloorIsNotLevel) {
  const auto [height_m, suspect] = height_after_climbing(false);
  EXPECT_NEAR(height_m, 0.125, 0.02);
  EXPECT_FALSE(suspect);
}

TEST(Filter, AHeightThatContradictsTheOtherSensorsIsSuspectAndLosesItsWeight) {
  double sigma[2], error_m[2];
  for (const bool wrong : {false, true}) {
    Filter filter = filter_at_start({});
    bool suspect = false;
    const int frames = short_walk().walk().frames();
    for (int k = 0; k < frames; ++k) {
      Observation o = short_walk().observation(k);
      if (wrong) o.plan->X_PC.translation().z() += k / 15 % 2 == 0 ? 0.02 : -0.02;
      suspect = suspect || filter.step(o).suspect == "inconsistent: height, the floor is not level";
    }
    EXPECT_EQ(suspect, wrong);
    sigma[wrong] = std::sqrt(filter.estimate().covariance(5, 5));
    error_m[wrong] =
        filter.estimate().X_WC.translation().z() -
        short_walk().walk().X_WC(seconds(short_walk().walk().stamp(frames - 1))).translation().z();
  }
  EXPECT_GT(sigma[1], 1.5 * sigma[0]);
  EXPECT_LT(std::abs(error_m[1]), 4 * sigma[1]);
}

TEST(Filter, RejectsMalformedObservationsWithoutChangingABit) {
  Filter filter = filter_at_start(Options{}), undisturbed = filter_at_start(Options{});
  for (Filter* f : {&filter, &undisturbed}) step(*f, 0, 40);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::string image = "the image is not an 8-bit gray image of the camera's size";
  const std::vector<std::pair<std::string, Spoil>> kinds{
      {"the observation is not later than the last one",
       [](auto& o) { o.t = short_walk().observation(39).t; }},
      {"the observation is not later than the last one",
       [](auto& o) { o.t = short_walk().observation(3).t; }},
      {"the observation is over 10 s after the last one", [](auto& o) { o.t += std::chrono::hours(1); }},
      {image, [](auto& o) { o.image = cv::Mat(240, 300, CV_8UC1, cv::Scalar(0)); }},
      {image, [](auto& o) { o.image = cv::Mat(240, 320, CV_8UC3, cv::Scalar(0)); }},
      {"an inertial reading is not finite", [](auto& o) { o.gyro[1].value.x() = kNan; }},
      {"an inertial reading is not finite", [](auto& o) { o.accelerometer[1].end = Stamp(-1); }},
      {"the plan is not finite", [](auto& o) { o.plan->p_CF.x() = kNan; }},
      {"the leg odometry is not finite", [](auto& o) { o.legs.emplace().p_CS.x() = kNan; }},
      {"the command is not finite", [](auto& o) { o.command.emplace().turn_rad_s = kNan; }}};
  for (const auto& [reason, spoil] : kinds) {
    EXPECT_EQ(step(filter, 40, 41, spoil).refused.text(), reason);
    EXPECT_EQ(fingerprint(filter), fingerprint(undisturbed)) << reason;
  }
  for (Filter* f : {&filter, &undisturbed}) step(*f, 40, 41);
  EXPECT_EQ(fingerprint(filter), fingerprint(undisturbed));
}

TEST(Filter, UsesOnlyTheAlignedDepthImageOfTheFrameAndRejectsAMalformedOne) {
  const auto depths = [](int sensor, Stamp late, const cv::Mat& mm) {
    Options options;
    options.depth.first_sight = FirstSight::measured_depth;
    Calibration calibration = synthetic::calibration();
    calibration.depth = AlignedDepth{3, 0.001};
    Filter filter(options, calibration, short_walk().walk().X_WC(0), 1);
    const FrameReport report = step(filter, 0, 1, [&](auto& o) {
      RigReading& reading = o.rig.emplace_back();
      reading.sensor = sensor, reading.t = o.t + late, reading.image = mm;
    });
    std::set<double> all;
    for (const MapPoint& point : filter.map())
      all.insert(std::round(100 * (filter.estimate().X_WC.inverse() * point.p_W).z()) / 100);
    return std::pair(all, report.refused.text());
  };
  const cv::Mat flat(240, 320, CV_16UC1, cv::Scalar(2500));
  EXPECT_EQ(depths(3, Stamp(0), flat).first, std::set{2.5});
  for (const auto& other : {depths(2, Stamp(0), flat), depths(3, Stamp(1), flat)}) {
    EXPECT_GT(other.first.size(), 1U);
    EXPECT_EQ(other.second, "");
  }
  EXPECT_EQ(depths(3, Stamp(0), flat.colRange(0, 319)).second,
            "the depth image is not a 16-bit image of the camera's size");
}

TEST(Filter, GivesTheSameBitsWithTheSameSeedAndAnotherMapWithAnother) {
  Filter a = filter_at_start({}, 3), b = filter_at_start({}, 3), c = filter_at_start({}, 4);
  for (Filter* filter : {&a, &b, &c}) step(*filter, 0, 30);
  EXPECT_EQ(fingerprint(a), fingerprint(b));
  EXPECT_NE(fingerprint(a), fingerprint(c));
}

// An image of a different place may delete landmarks.
TEST(Filter, IsLostAfterTwoSecondsWithoutAUsableImageStatesTheCauseAndKeepsItsMap) {
  const Spoil frozen = [last = short_walk().observation(19).image](Observation& o) { o.image = last; };
  const std::vector<std::tuple<std::string, Options, Spoil>> kinds{
      {"no image arrives", {}, lose_image},
      {"the image is flat", {}, [](Observation& o) { o.image.setTo(cv::Scalar(0)); }},
      {"the image is identical to the previous one", {}, frozen},
      {"the image is identical to the previous one", vision_only(), frozen},
      {"almost no landmarks were found", {}, [](Observation& o) { cv::flip(o.image, o.image, -1); }},
      {"observations are rejected because the image is not an 8-bit gray image of the camera's size",
       {},
       [](Observation& o) { o.image = cv::Mat(10, 10, CV_8UC1, cv::Scalar(0)); }}};
  for (const auto& [cause, options, spoil] : kinds) {
    Filter filter = filter_at_start(options);
    EXPECT_EQ(step(filter, 0, 20).health, Health::ok) << cause;
    const std::size_t landmarks = filter.map().size();
    const FrameReport report = step(filter, 20, short_walk().walk().frames(), spoil);
    EXPECT_EQ(report.health, Health::lost) << cause;
    EXPECT_EQ(report.cause, "tracking lost: " + cause);
    if (cause != "almost no landmarks were found") {
      EXPECT_EQ(filter.map().size(), landmarks) << cause;
    }
  }
}

TEST(Filter, AGapWithoutFramesAndAStoppedClockCountAsLosses) {
  Filter with_gap = filter_at_start(Options{});
  step(with_gap, 0, 20);
  EXPECT_EQ(step(with_gap, 85, 86).cause, "tracking lost: no frame arrives");  // 2.2 s later
  Filter filter = filter_at_start(Options{});
  step(filter, 0, 20);
  for (int k = 0; k < 58; ++k) EXPECT_EQ(step(filter, 19, 20).health, Health::ok) << k;
  for (int k = 0; k < 4; ++k) step(filter, 19, 20);
  EXPECT_EQ(step(filter, 19, 20).health, Health::lost);
  EXPECT_EQ(step(filter, 20, 21).health, Health::ok);
}

TEST(Filter, ABlindFilterRecoversWithItsMapAndRepeatedObservationsDoNotCountAsBlindTime) {
  Options options;
  options.tracking.lost_after_s = options.tracking.give_up_s = 0.5;
  Filter once = filter_at_start(options), thrice = filter_at_start(options);
  for (int k = 0; k < 60; ++k) {
    const Spoil spoil = k >= 20 && k < 44 ? Spoil(lose_image) : [](Observation&) {};
    const FrameReport report = step(once, k, k + 1, spoil);
    FrameReport repeated;
    for (int i = 0; i < 3; ++i) repeated = step(thrice, k, k + 1, spoil);
    EXPECT_EQ(report.health, k < 35 || k >= 44 ? Health::ok : Health::lost) << k;
    EXPECT_FALSE(report.relocalized) << "the predicted pose is good enough";
    EXPECT_EQ(repeated.health, report.health) << k;
    EXPECT_EQ(repeated.cause, report.cause) << k;
  }
}

TEST(Filter, WithoutImagesPlanAndSensorsItsUncertaintyGrowsUntilItIsLost) {
  Filter filter = filter_at_start(Options{});
  double before = 0;
  for (int k = 0; k < 60; ++k) {
    Observation o = short_walk().observation(k);
    if (k >= 30) o = {o.t, {}, {}, {}, {}, {}, {}, {}, {}};
    const Health health = filter.step(o).health;
    const Eigen::Matrix<double, 6, 1> variance = filter.estimate().covariance.diagonal();
    const bool certain =
        variance.head<3>().maxCoeff() < 0.05 * 0.05 && variance.tail<3>().maxCoeff() < 0.1 * 0.1;
    EXPECT_EQ(health, certain ? Health::ok : Health::lost) << k;
    EXPECT_TRUE(k >= 30 ? k < 45 || !certain : certain) << k;
    const double trace = filter.estimate().covariance.trace();
    EXPECT_TRUE(k < 30 || trace > before) << k;
    before = trace;
  }
  EXPECT_TRUE(filter.estimate().X_WC.matrix().allFinite());
}

TEST(Filter, LandmarksAreMappedWhereTheyWereSeenWithinTheirUncertainty) {
  const synthetic::Recording& recording = short_walk();
  const synthetic::Room room;
  const Camera camera(synthetic::calibration().camera);
  Filter filter = filter_at_start(Options{});
  std::map<int, Eigen::Vector3d> seen;
  for (int k = 0; k < recording.walk().frames(); ++k) {
    const Eigen::Isometry3d X_WC = recording.walk().X_WC(seconds(recording.walk().stamp(k)));
    for (const Sighting& first : filter.step(recording.observation(k)).initialized)
      seen[first.landmark] = room.hit(X_WC.translation(), X_WC.linear() * camera.unproject(first.pixel)->h);
  }
  int within = 0, measured = 0;
  for (const MapPoint& p : filter.map()) {
    if (p.successes < 60) continue;
    ++measured;
    const Eigen::Vector3d error = seen.at(p.id) - p.p_W;
    if (error.dot(p.covariance.ldlt().solve(error)) < 16.3) ++within;  // chi-square of 3, 99.9 %
  }
  EXPECT_GE(measured, 5);
  EXPECT_GE(within, 0.7 * measured);  // depths are not Gaussian at first, and some corners lie on edges
}

}  // namespace
}  // namespace slam
