// The whole filter: what it refuses, what it survives, and short walks through the synthetic room.
#include "slam/filter.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <map>
#include <opencv2/core.hpp>

#include "tests/slam/synthetic_room.h"

namespace slam {
namespace {

using synthetic::Path;

/// A quarter of a minute's fraction that still holds a few steps and some turning; rendered once per process.
const synthetic::Recording& short_walk() {
  static const synthetic::Recording recording = [] {
    synthetic::Walk walk;
    walk.duration_s = 3.5;
    walk.turns = 0.1;
    return synthetic::Recording(walk, synthetic::render(synthetic::Room(), walk));
  }();
  return recording;
}

Filter filter_at_start(const Options& options) {
  return {options, synthetic::calibration(), short_walk().walk().X_WC(0), 1};
}

struct Errors {
  double rms_m = 0, sigma_end_m = 0, nees_position = 0;
  int accepted = 0, refused = 0;
  bool sound = true;
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
    e.sound = e.sound && report.health == Health::ok && P.allFinite() && P == P.transpose();
  }
  e.rms_m = std::sqrt(e.rms_m);
  return e;
}

TEST(Filter, FollowsAShortWalkWithinItsOwnUncertainty) {
  const Errors e = walk(Options{});
  EXPECT_TRUE(e.sound);
  EXPECT_LT(e.rms_m, 0.02);  // the plan alone is off by 3 % of 0.7 m of path and by its excess turn
  EXPECT_LT(e.nees_position,
            8);  // 3 expected; one walk's errors hang together, 99 % of chi-square(3) is 11.3
  EXPECT_GT(e.accepted, 5 * short_walk().walk().frames());
}

TEST(Filter, WithoutThePlanOrTheAccelerometerThereIsNoScaleAndTheWalkIsFollowedWorse) {
  Options vision_alone;
  vision_alone.gyro.enabled = vision_alone.accelerometer.enabled = false;
  vision_alone.plan_velocity.enabled = vision_alone.height.enabled = false;
  EXPECT_GT(walk(vision_alone).rms_m, 3 * walk(Options{}).rms_m);
}

TEST(Filter, WithoutVisionItKnowsThatItDriftsMore) {
  Options blind;
  blind.vision.enabled = false;
  const Errors e = walk(blind);
  EXPECT_TRUE(e.sound);
  EXPECT_EQ(e.accepted, 0);
  EXPECT_GT(e.sigma_end_m, walk(Options{}).sigma_end_m);
}

TEST(Filter, SurvivesTheLossOfImagesGyroAndPlanAtOnce) {
  const Errors e = walk(Options{}, [](int k, Observation& o) {
    if (k >= 50 && k < 70) o.image = cv::Mat();
    if (k >= 60 && k < 80) o.gyro.clear(), o.accelerometer.clear();
    if (k >= 40 && k < 66) o.plan.reset();
  });
  EXPECT_TRUE(e.sound);
  EXPECT_LT(e.rms_m, 0.04);  // 10 frames have neither image nor gyro
}

TEST(Filter, GatesAndReportsASpikeOfTheGyroAndOfTheAccelerometer) {
  const Errors clean = walk(Options{});
  const Errors spiked = walk(Options{}, [](int k, Observation& o) {
    if (k == 80) o.gyro[2].value += Eigen::Vector3d(40, 0, 0);
    if (k == 100) o.accelerometer[2].value += Eigen::Vector3d(0, 150, 0);
  });
  EXPECT_TRUE(spiked.sound);
  EXPECT_GE(spiked.refused, 2);
  EXPECT_LT(spiked.rms_m, clean.rms_m + 0.005);
}

TEST(Filter, StandingStillWithARateOfExactlyZeroIsFinite) {
  const Errors e = walk(Options{}, [](int, Observation& o) {
    for (InertialSample& sample : o.gyro) sample.value.setZero();
    o.image = cv::Mat();
  });
  EXPECT_TRUE(e.sound);
}

/// What a filter says of itself, in bits that can be compared.
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

TEST(Filter, RefusesMalformedObservationsAndIsLeftBitIdentical) {
  Filter filter = filter_at_start(Options{}), undisturbed = filter_at_start(Options{});
  const synthetic::Recording& recording = short_walk();
  for (int k = 0; k < 40; ++k) {
    filter.step(recording.observation(k));
    undisturbed.step(recording.observation(k));
  }
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::function<void(Observation&)>> spoil{
      [&](Observation& o) { o.t = recording.observation(39).t; },
      [&](Observation& o) { o.t = recording.observation(3).t; },
      [](Observation& o) { o.t += std::chrono::hours(1); },
      [](Observation& o) { o.image = cv::Mat(240, 300, CV_8UC1, cv::Scalar(0)); },
      [](Observation& o) { o.image = cv::Mat(240, 320, CV_8UC3, cv::Scalar(0)); },
      [](Observation& o) { o.gyro[1].value.x() = kNan; },
      [](Observation& o) { o.accelerometer[1].value.y() = std::numeric_limits<double>::infinity(); },
      [](Observation& o) { o.plan->X_PC.translation().z() = kNan; }};
  for (std::size_t i = 0; i < spoil.size(); ++i) {
    Observation o = recording.observation(40);
    spoil[i](o);
    EXPECT_NE(filter.step(o).refused, "") << i;
    EXPECT_EQ(fingerprint(filter), fingerprint(undisturbed)) << i;
  }
  filter.step(recording.observation(40));
  undisturbed.step(recording.observation(40));
  EXPECT_EQ(fingerprint(filter), fingerprint(undisturbed));
}

TEST(Filter, ADarkImageIsReportedAndCostsNoLandmark) {
  Filter filter = filter_at_start(Options{});
  const synthetic::Recording& recording = short_walk();
  for (int k = 0; k < 30; ++k) filter.step(recording.observation(k));
  const std::size_t landmarks = filter.map().size();
  for (int k = 30; k < 60; ++k) {
    Observation o = recording.observation(k);
    o.image = cv::Mat(240, 320, CV_8UC1, cv::Scalar(3));
    EXPECT_NE(filter.step(o).refused, "");
  }
  EXPECT_EQ(filter.map().size(), landmarks);
  EXPECT_GT(filter.step(recording.observation(60)).accepted, 5);
}

TEST(Filter, SaysThatTrackingIsLostWhenItSeesAnotherRoom) {
  const synthetic::Recording& recording = short_walk();
  Filter filter = filter_at_start(Options{});
  Health health = Health::ok;
  std::string cause;
  for (int k = 0; k < recording.walk().frames() && health == Health::ok; ++k) {
    Observation o = recording.observation(k);
    if (k > 30) cv::flip(o.image, o.image, -1);
    const FrameReport& report = filter.step(o);
    health = report.health;
    cause = report.cause;
  }
  EXPECT_EQ(health, Health::lost);
  EXPECT_NE(cause.find("tracking lost"), std::string::npos);
}

TEST(Filter, LandmarksAreMappedWhereTheyWereSeenWithinTheirUncertainty) {
  const synthetic::Recording& recording = short_walk();
  const synthetic::Room room;
  const Camera camera(synthetic::calibration().camera);
  Filter filter = filter_at_start(Options{});
  std::map<int, Eigen::Vector3d> seen;
  for (int k = 0; k < recording.walk().frames(); ++k) {
    const Eigen::Isometry3d X_WC = recording.walk().X_WC(seconds(recording.walk().stamp(k)));
    for (const Sighting& begun : filter.step(recording.observation(k)).begun)
      seen[begun.landmark] = room.hit(X_WC.translation(), X_WC.linear() * camera.unproject(begun.pixel)->h);
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
            0.7 * measured);  // depths begin far from Gaussian; some corners lie on edges of furniture
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
    ASSERT_GT(yaw, 0.02 * 0.99) << k;  // 1 %: tilt, which gravity tells, and heading hang together a little
  }
}

}  // namespace
}  // namespace slam
