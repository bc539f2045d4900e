#include "slam/filter.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <map>
#include <opencv2/core.hpp>
#include <tuple>

#include "tests/slam/synthetic_room.h"

namespace slam {
namespace {

/// A walk of a few steps and some turning, rendered once per process.
const synthetic::Recording& short_walk() {
  static const synthetic::Recording recording = [] {
    synthetic::Walk walk;
    walk.duration_s = 3.5;
    walk.turns = 0.1;
    return synthetic::Recording(walk, synthetic::render(synthetic::Room(), walk));
  }();
  return recording;
}

/// The view of its camera at the start, without noise.
cv::Mat short_walk_image() {
  return synthetic::Room().render(Camera(synthetic::calibration().camera), short_walk().walk().X_WC(0), 1);
}

Filter filter_at_start(const Options& options, std::uint64_t seed = 1) {
  return {options, synthetic::calibration(), short_walk().walk().X_WC(0), seed};
}

using Spoil = std::function<void(Observation&)>;

/// Steps through the frames [from, to) of the short walk, each spoiled before; returns the last report.
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
  double rms_m = 0, sigma_end_m = 0, nees_position = 0;
  int accepted = 0, refused = 0, lost = 0;  // lost: frames with a health that is not ok
  bool valid = true;                        // the covariance is finite and symmetric
  bool sound() const { return valid && lost == 0; }
};

using Change = std::function<void(int, Observation&)>;

/// Walks the short walk; `change` is done to each observation before the filter sees it.
Errors walk(
    const Options& options, const Change& change = [](int, Observation&) {}) {
  const synthetic::Recording& recording = short_walk();
  Filter filter = filter_at_start(options);
  Errors e;
  const int frames = recording.walk().frames();
  for (int k = 0; k < frames; ++k) {
    Observation o = recording.observation(k);
    change(k, o);
    const FrameReport& report = filter.step(o);
    e.accepted += report.accepted;
    e.refused += report.refused.empty() ? 0 : 1;
    const Matrix6d& P = filter.estimate().covariance;
    const Eigen::Isometry3d X_WC = recording.walk().X_WC(seconds(recording.walk().stamp(k)));
    const Eigen::Vector3d error = X_WC.translation() - filter.estimate().X_WC.translation();
    e.rms_m += error.squaredNorm() / frames;
    e.nees_position += error.dot(P.bottomRightCorner<3, 3>().llt().solve(error)) / frames;
    e.sigma_end_m = std::sqrt(P.bottomRightCorner<3, 3>().trace());
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

TEST(Filter, FollowsAShortWalkWithinItsOwnUncertainty) {
  const Errors& e = default_walk();
  EXPECT_TRUE(e.sound());
  EXPECT_LT(e.rms_m, 0.02);  // the plan is off by 3 % of 0.7 m of path and by its excess turn
  EXPECT_LT(e.nees_position,
            8);  // 3 expected; one walk's errors are correlated, 99 % of chi-square(3) is 11.3
  EXPECT_GT(e.accepted, 5 * short_walk().walk().frames());
}

TEST(Filter, WithoutPlanAndAccelerometerItHasNoScaleAndFollowsTheWalkWorse) {
  // How wrong the scale is without any measurement of it is chance; that the filter does not know it is not.
  const Errors only_vision = walk(vision_only());
  EXPECT_GT(only_vision.rms_m, default_walk().rms_m);
  EXPECT_GT(only_vision.sigma_end_m, 3 * default_walk().sigma_end_m);
}

TEST(Filter, WithoutVisionItsUncertaintyIsLarger) {
  Options blind;
  blind.vision.enabled = false;
  const Errors e = walk(blind);
  EXPECT_TRUE(e.sound());
  EXPECT_EQ(e.accepted, 0);
  EXPECT_GT(e.sigma_end_m, default_walk().sigma_end_m);
}

TEST(Filter, SurvivesTheLossOfImagesGyroAndPlanAtOnce) {
  const Errors e = walk(Options{}, [](int k, Observation& o) {
    if (k >= 50 && k < 70) o.image = cv::Mat();
    if (k >= 60 && k < 80) o.gyro.clear(), o.accelerometer.clear();
    if (k >= 40 && k < 66) o.plan.reset();
  });
  EXPECT_TRUE(e.valid);
  // 10 frames have neither image nor gyro: the first image after them may not fit the prediction, and the
  // filter recognizes its map in the next one.
  EXPECT_LE(e.lost, 1);
  EXPECT_LT(e.rms_m, 0.04);
}

TEST(Filter, GatesAndReportsASpikeOfTheGyroAndOfTheAccelerometer) {
  const Errors spiked = walk(Options{}, [](int k, Observation& o) {
    if (k == 80) o.gyro[2].value += Eigen::Vector3d(40, 0, 0);
    if (k == 100) o.accelerometer[2].value += Eigen::Vector3d(0, 150, 0);
  });
  EXPECT_TRUE(spiked.sound());
  EXPECT_GE(spiked.refused, 2);
  EXPECT_LT(spiked.rms_m, default_walk().rms_m + 0.005);
}

TEST(Filter, StandingStillWithARateOfExactlyZeroIsFinite) {
  Options blind;
  blind.vision.enabled = false;
  const Errors e = walk(blind, [](int, Observation& o) {
    for (InertialSample& sample : o.gyro) sample.value.setZero();
  });
  EXPECT_TRUE(e.sound());
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

TEST(Filter, RejectsMalformedObservationsAndIsLeftBitIdentical) {
  Filter filter = filter_at_start(Options{}), undisturbed = filter_at_start(Options{});
  for (Filter* f : {&filter, &undisturbed}) step(*f, 0, 40);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Spoil> spoil{
      [](auto& o) { o.t = short_walk().observation(39).t; },
      [](auto& o) { o.t = short_walk().observation(3).t; },
      [](auto& o) { o.t += std::chrono::hours(1); },
      [](auto& o) { o.image = cv::Mat(240, 300, CV_8UC1, cv::Scalar(0)); },
      [](auto& o) { o.image = cv::Mat(240, 320, CV_8UC3, cv::Scalar(0)); },
      [](auto& o) { o.gyro[1].value.x() = kNan; },
      [](auto& o) { o.accelerometer[1].value.y() = std::numeric_limits<double>::infinity(); },
      [](auto& o) { o.plan->X_PC.translation().z() = kNan; }};
  for (std::size_t i = 0; i < spoil.size(); ++i) {
    EXPECT_NE(step(filter, 40, 41, spoil[i]).refused, "") << i;
    EXPECT_EQ(fingerprint(filter), fingerprint(undisturbed)) << i;
  }
  for (Filter* f : {&filter, &undisturbed}) step(*f, 40, 41);
  EXPECT_EQ(fingerprint(filter), fingerprint(undisturbed));
}

TEST(Filter, SameSeedGivesTheSameBitsAndAnotherSeedAnotherMap) {
  Filter a = filter_at_start({}, 3), b = filter_at_start({}, 3), c = filter_at_start({}, 4);
  for (Filter* filter : {&a, &b, &c}) step(*filter, 0, 30);
  EXPECT_EQ(fingerprint(a), fingerprint(b));
  EXPECT_NE(fingerprint(a), fingerprint(c));
}

TEST(Filter, FlatAndFrozenImagesAreNamedAndCostNoLandmark) {
  for (const double gray : {-1.0, 0.0, 255.0}) {  // -1: the last image again
    Filter filter = filter_at_start(Options{});
    step(filter, 0, 30);
    const cv::Mat image =
        gray < 0 ? short_walk().observation(29).image : cv::Mat(240, 320, CV_8UC1, cv::Scalar(gray));
    const std::size_t landmarks = filter.map().size();
    for (int k = 30; k < 45; ++k)
      EXPECT_EQ(step(filter, k, k + 1, [&](Observation& o) { o.image = image; }).refused,
                gray < 0 ? "the image is the last one again" : "the image is flat");
    EXPECT_EQ(filter.map().size(), landmarks);
    EXPECT_GT(step(filter, 45, 46).accepted, 5);
  }
}

TEST(Filter, WithoutAUsableImageForTwoSecondsItIsLostAndNamesTheCause) {
  const Spoil frozen = [last = short_walk().observation(19).image](Observation& o) { o.image = last; };
  const std::vector<std::tuple<std::string, Options, Spoil>> kinds{
      {"no image arrives", {}, lose_image},
      {"the image is flat", {}, [](Observation& o) { o.image.setTo(cv::Scalar(0)); }},
      {"the image is the last one again", {}, frozen},
      {"the image is the last one again", vision_only(), frozen},
      {"almost no landmark found", {}, [](Observation& o) { cv::flip(o.image, o.image, -1); }},
      {"observations are rejected because its image is not 8-bit gray of the camera's size",
       {},
       [](Observation& o) { o.image = cv::Mat(10, 10, CV_8UC1, cv::Scalar(0)); }}};
  for (const auto& [cause, options, spoil] : kinds) {
    Filter filter = filter_at_start(options);
    EXPECT_EQ(step(filter, 0, 20).health, Health::ok) << cause;
    const FrameReport report = step(filter, 20, short_walk().walk().frames(), spoil);
    EXPECT_EQ(report.health, Health::lost) << cause;
    EXPECT_EQ(report.cause, "tracking lost: " + cause);
  }
}

TEST(Filter, ABlindFilterIsOkAgainOnceItSeesItsMapAndDivergesIfItDoesNotInTime) {
  Options options;
  options.tracking.lost_after_s = options.tracking.give_up_s = 0.5;
  Filter filter = filter_at_start(options), other = filter_at_start(options);
  for (Filter* f : {&filter, &other}) {
    step(*f, 0, 20);
    EXPECT_EQ(step(*f, 20, 35, lose_image).health, Health::ok);
    EXPECT_EQ(step(*f, 35, 36, lose_image).health, Health::lost);
    step(*f, 36, 40, lose_image);
  }
  const FrameReport found = step(filter, 40, 41);
  EXPECT_EQ(found.health, Health::ok);
  EXPECT_GT(found.accepted, 5);
  EXPECT_FALSE(found.relocalized);  // the predicted pose was good enough
  step(other, 40, 60, lose_image);
  EXPECT_EQ(step(other, 60, 61).health, Health::diverged);
}

TEST(Filter, AGapWithoutAnyFrameIsReportedAsALoss) {
  Filter filter = filter_at_start(Options{});
  step(filter, 0, 20);
  const FrameReport after = step(filter, 85, 86);  // 2.2 s later
  EXPECT_EQ(after.health, Health::lost);
  EXPECT_EQ(after.cause, "tracking lost: no frame arrives");
}

TEST(Filter, AClockThatStandsStillIsALoss) {
  Filter filter = filter_at_start(Options{});
  step(filter, 0, 20);
  for (int k = 0; k < 58; ++k) EXPECT_EQ(step(filter, 19, 20).health, Health::ok) << k;
  for (int k = 0; k < 4; ++k) step(filter, 19, 20);
  EXPECT_EQ(step(filter, 19, 20).health, Health::lost);
  EXPECT_EQ(step(filter, 20, 21).health, Health::ok);
}

/// Health and cause in each frame of the short walk with half a second as both limits and without images for
/// 0.8 s. The filter receives each observation `times` times.
std::vector<std::string> health_without_images_for_a_while(int times) {
  Options options;
  options.tracking.lost_after_s = options.tracking.give_up_s = 0.5;
  Filter filter = filter_at_start(options);
  std::vector<std::string> all;
  for (int k = 0; k < 60; ++k) {
    Observation o = short_walk().observation(k);
    if (k >= 20 && k < 44) o.image = cv::Mat();
    FrameReport report;
    for (int i = 0; i < times; ++i) report = filter.step(o);
    all.push_back((report.health == Health::ok ? "ok" : "not ok; ") + report.cause);
  }
  return all;
}

TEST(Filter, RepeatedObservationsDoNotCountAsTimeWithoutSight) {
  const auto once = health_without_images_for_a_while(1);
  EXPECT_EQ(once[34], "ok");
  EXPECT_EQ(once[35], "not ok; tracking lost: no image arrives");
  EXPECT_EQ(once[44], "ok");
  EXPECT_EQ(health_without_images_for_a_while(3), once);
}

TEST(Filter, StandingStillWithImagesIsNotALossWithAndWithoutNoise) {
  for (const double noise : {0.0, 2.0}) {
    synthetic::Walk still = short_walk().walk();
    still.duration_s = 6, still.stand_s = 6, still.turns = 0, still.image_sigma = noise;
    still.sway_m = still.bounce_m = 0;
    const synthetic::Recording recording(
        still, std::vector<cv::Mat>(static_cast<std::size_t>(still.frames()), short_walk_image()));
    Filter filter(Options{}, synthetic::calibration(), still.X_WC(0), 1);
    for (int k = 0; k < still.frames(); ++k)
      ASSERT_EQ(filter.step(recording.observation(k)).health, Health::ok) << noise << ' ' << k;
  }
}

TEST(Filter, KeepsToTheBoundsOfItsMapAndOfItsWork) {
  Options options;
  options.vision.visible_landmarks = options.vision.measured_landmarks = 1000;
  options.bounds.landmarks = 9;
  options.bounds.measured = 7;
  Filter filter = filter_at_start(options);
  for (int k = 0; k < short_walk().walk().frames(); ++k) {
    const FrameReport& report = filter.step(short_walk().observation(k));
    ASSERT_LE(report.landmarks, 9);
    ASSERT_LE(report.searched.size(), 7u);
    ASSERT_EQ(report.health, Health::ok) << report.cause;
  }
  EXPECT_EQ(filter.map().size(), 9u);
}

TEST(Filter, WithoutImagesPlanAndSensorsTheUncertaintyGrowsFromFrameToFrame) {
  Filter filter = filter_at_start(Options{});
  double before = 0;
  for (int k = 0; k < 60; ++k) {
    Observation o = short_walk().observation(k);
    if (k >= 30) o = {o.t, {}, {}, {}, {}};
    EXPECT_EQ(filter.step(o).health, Health::ok);
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
  EXPECT_GE(within,
            0.7 * measured);  // depths are far from Gaussian at first; some corners lie on edges of furniture
}

/// Position NEES after standing still, from a start with an error drawn from the options.
double nees_after_standing(std::uint64_t seed) {
  synthetic::Recording noisy = short_walk();
  noisy.reseed(seed);
  synthetic::Normal normal(seed);
  Options options;
  options.plan_velocity.sigma_sway_m_s = options.plan_velocity.sigma_stride = 0;  // it stands still
  // wide enough to be most of the error: the room's images are better than vision.sigma_px
  options.start.sigma_position_m = options.start.sigma_orientation_rad = 0.01;
  Eigen::Isometry3d start = noisy.walk().X_WC(0);
  const Eigen::Vector3d turn =
      options.start.sigma_orientation_rad * Eigen::Vector3d(normal(), normal(), normal());
  start.linear() = start.linear() * Eigen::AngleAxisd(turn.norm(), turn.normalized());
  start.translation() += options.start.sigma_position_m * Eigen::Vector3d(normal(), normal(), normal());
  Filter f(options, synthetic::calibration(), start, seed);
  for (int k = 0; k < 12; ++k) f.step(noisy.observation(k));
  const Eigen::Vector3d error = noisy.walk().X_WC(0).translation() - f.estimate().X_WC.translation();
  return error.dot(f.estimate().covariance.bottomRightCorner<3, 3>().llt().solve(error));
}

TEST(Filter, ErrorsOverManyStartsMatchTheCovariance) {
  constexpr int kRuns = 30;
  double mean = 0;
  for (int seed = 1; seed <= kRuns; ++seed)
    mean += nees_after_standing(static_cast<std::uint64_t>(seed)) / kRuns;
  // chi-square of 3 x 30: 99.9 % of such means lie between 1.74 and 4.69 for a consistent filter
  EXPECT_GT(mean, 1.74);
  EXPECT_LT(mean, 4.69);
}

TEST(Filter, TheHeadingsUncertaintyNeverFallsBelowWhatItWasAtTheStart) {
  const synthetic::Recording& recording = short_walk();
  Options options;
  options.start.sigma_orientation_rad = 0.02;
  Filter filter = filter_at_start(options);
  for (int k = 0; k < recording.walk().frames(); ++k) {
    filter.step(recording.observation(k));
    const Eigen::Vector3d up_C = filter.estimate().X_WC.linear().transpose() * Eigen::Vector3d::UnitZ();
    const double yaw = std::sqrt(up_C.dot(filter.estimate().covariance.topLeftCorner<3, 3>() * up_C));
    ASSERT_GT(yaw, 0.02 * 0.99) << k;  // 1 %: heading is slightly correlated with tilt, which gravity reveals
  }
}

}  // namespace
}  // namespace slam
