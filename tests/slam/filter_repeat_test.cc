// The filter run twice: the same from the same seed, and no worse than honest where its camera tells nothing.
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "slam/filter.h"
#include "slam/motion_model.h"
#include "slam/plan.h"
#include "tests/slam/synthetic_room.h"

namespace slam {
namespace {

constexpr int kSeen = 12;  // frames, at 10 Hz

const synthetic::Recording& recording() {
  static const synthetic::Recording recording = [] {
    synthetic::Walk walk;
    walk.rate_hz = 10;
    walk.duration_s = 2.4;
    walk.stand_s = 0.1 * kSeen;  // then it turns about, fast
    walk.radius_m = 0.1;
    return synthetic::Recording(walk, synthetic::render(synthetic::Room(), walk));
  }();
  return recording;
}

Filter filter(std::uint64_t seed) {
  return Filter(Options(), synthetic::calibration(), recording().walk().X_WC(0), seed);
}

/// Runs over all frames; from frame kSeen on, `spoil` has its way with what the filter is given.
template <typename Spoil>
std::vector<FrameReport> run(Filter& filter, const Spoil& spoil) {
  std::vector<FrameReport> reports;
  for (int k = 0; k < recording().walk().frames(); ++k) {
    Observation o = recording().observation(k);
    if (k >= kSeen) spoil(o);
    reports.push_back(filter.step(o));
  }
  return reports;
}

void nothing(Observation&) {}

TEST(FilterRepeat, SameSeedGivesTheSameBitsAndAnotherSeedAnotherMap) {
  Filter a = filter(3), b = filter(3), c = filter(4);
  run(a, nothing), run(b, nothing), run(c, nothing);
  EXPECT_EQ(a.estimate().X_WC.matrix(), b.estimate().X_WC.matrix());
  EXPECT_EQ(a.estimate().covariance, b.estimate().covariance);
  EXPECT_NE(a.estimate().X_WC.matrix(), c.estimate().X_WC.matrix());
}

TEST(FilterRepeat, BlackAndWhiteImagesAreNamedAndTakeNoLandmarkAway) {
  for (const double grey : {0.0, 255.0}) {
    Filter f = filter(3);
    const auto reports = run(f, [&](Observation& o) { o.image.setTo(cv::Scalar(grey)); });
    EXPECT_EQ(reports.back().landmarks, reports[kSeen - 1].landmarks) << grey;
    EXPECT_GT(reports.back().landmarks, 0);
    EXPECT_NE(reports.back().refused.find("flat"), std::string::npos) << grey;
    EXPECT_EQ(reports.back().health, Health::ok);
  }
}

TEST(FilterRepeat, WithoutImagesPlanAndSensorsUncertaintyGrowsFromFrameToFrame) {
  Filter f = filter(3);
  double before = 0;
  for (int k = 0; k < recording().walk().frames(); ++k) {
    Observation o = recording().observation(k);
    if (k >= kSeen) {
      o.image = cv::Mat();
      o.gyro.clear();
      o.accelerometer.clear();
      o.plan.reset();
    }
    EXPECT_EQ(f.step(o).health, Health::ok);
    const double trace = f.estimate().covariance.trace();
    EXPECT_TRUE(k < kSeen || trace > before) << k;
    before = trace;
  }
  EXPECT_TRUE(f.estimate().X_WC.matrix().allFinite());
}

TEST(FilterRepeat, AFrozenImageLeavesTheFilterFiniteAndOkOrDivergedWithACause) {
  Filter f = filter(3);
  const cv::Mat frozen = recording().observation(kSeen).image;
  const auto reports = run(f, [&](Observation& o) { o.image = frozen.clone(); });
  EXPECT_TRUE(f.estimate().X_WC.matrix().allFinite());
  EXPECT_TRUE(f.estimate().covariance.allFinite());
  EXPECT_EQ(reports.back().health == Health::ok, reports.back().cause.empty());
}

TEST(FilterRepeat, SignOfTheQuaternionDoesNotMatterToMotionOrPlan) {
  RobotVector x = RobotVector::LinSpaced(-0.4, 0.9);
  x.segment<4>(kOrientation).normalize();
  RobotVector flipped = x;
  flipped.segment<4>(kOrientation) *= -1;
  const Impulse impulse{{0.02, -0.33, 0.05}, 0.03, 0.001};
  RobotVector a = predict_motion(x, 0.03, impulse, Options()).x;
  const RobotVector b = predict_motion(flipped, 0.03, impulse, Options()).x;
  a.segment<4>(kOrientation) *= -1;
  EXPECT_EQ(a, b);
  const PlannedStride stride{{0.2, 0, 0.1}, {0.1, 0, 0}, {0, 1.3, 0}};
  EXPECT_EQ(Eigen::Vector3d(measure_velocity(x, stride, {}).innovation),
            Eigen::Vector3d(measure_velocity(flipped, stride, {}).innovation));
}

/// Position NEES after standing still, from a start that is off by what the options say it may be.
double nees_after_standing(std::uint64_t seed) {
  synthetic::Recording noisy = recording();
  noisy.reseed(seed);
  synthetic::Normal normal(seed);
  Options options;
  options.plan_velocity.sigma_sway_m_s = options.plan_velocity.sigma_stride = 0;  // this one does not sway
  // wide enough to be most of the error: the room's images are better than vision.sigma_px says
  options.start.sigma_position_m = options.start.sigma_orientation_rad = 0.01;
  Eigen::Isometry3d start = noisy.walk().X_WC(0);
  const Eigen::Vector3d turn =
      options.start.sigma_orientation_rad * Eigen::Vector3d(normal(), normal(), normal());
  start.linear() = start.linear() * Eigen::AngleAxisd(turn.norm(), turn.normalized());
  start.translation() += options.start.sigma_position_m * Eigen::Vector3d(normal(), normal(), normal());
  Filter f(options, synthetic::calibration(), start, seed);
  for (int k = 0; k < kSeen; ++k) f.step(noisy.observation(k));
  const Eigen::Vector3d error = noisy.walk().X_WC(0).translation() - f.estimate().X_WC.translation();
  return error.dot(f.estimate().covariance.bottomRightCorner<3, 3>().llt().solve(error));
}

TEST(FilterRepeat, ErrorsOverManyStartsAreAsLargeAsTheFilterSays) {
  constexpr int kRuns = 30;
  double mean = 0;
  for (int seed = 1; seed <= kRuns; ++seed)
    mean += nees_after_standing(static_cast<std::uint64_t>(seed)) / kRuns;
  // chi-square of 3 x 30: 99.9 % of such means lie between 1.74 and 4.69 where the filter is right
  EXPECT_GT(mean, 1.74);
  EXPECT_LT(mean, 4.69);
}

}  // namespace
}  // namespace slam
