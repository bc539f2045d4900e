#include "slam/vision/relocalization.h"

#include "slam/filter.h"
#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

Eigen::Isometry3d tilted(double yaw, const Eigen::Vector3d& at) {
  return pose(yaw, {0, 0, 1}, at) * pose(0.3, {0.6, -0.8, 0}, {0, 0, 0});
}

BearingObservation seen(const Eigen::Isometry3d& X_WC, const Eigen::Vector3d& p_W) {
  return {p_W, (X_WC.inverse() * p_W).normalized()};
}

TEST(PosesFromTwo, ContainTheTruePoseWhateverTheHeadingOfTheGuess) {
  const Eigen::Isometry3d X_WC = tilted(2.2, {0.4, -0.7, 1.4});
  const BearingObservation a = seen(X_WC, {3, 1, 2}), b = seen(X_WC, {-1, 4, 0.5});
  for (const double guess : {-2.0, 0.0, 0.3, 3.0}) {
    double nearest = 1e9;
    for (const Eigen::Isometry3d& found : poses_from_two(a, b, tilted(guess, {0, 0, 0}).linear()))
      nearest = std::min(nearest, (found.matrix() - X_WC.matrix()).norm());
    EXPECT_LT(nearest, 1e-9) << guess;
  }
}

TEST(PosesFromTwo, DoNotExistIfTheRaysCannotMeet) {
  const BearingObservation a{{0, 0, 5}, {1, 0, 0}}, b{{0, 0, -5}, {0, 1, 0}};  // level, 10 m apart in height
  EXPECT_TRUE(poses_from_two(a, b, Eigen::Matrix3d::Identity()).empty());
}

TEST(Relocalization, TheRobotsStateGetsTheFoundPoseWalkingVelocitiesAndItsOldBiases) {
  State before;
  before.storage_x = RobotVector::LinSpaced(0.1, 3.0);
  before.storage_P = RobotMatrix::Identity() * 0.5;
  const Estimate found{Stamp(0), tilted(0.4, {1, 2, 3}), 0.01 * Matrix6d::Identity()};
  const RobotState after = relocalized_state(found, before);
  EXPECT_EQ(after.x.head<3>(), Eigen::Vector3d(1, 2, 3));
  EXPECT_LT((rotation_matrix(after.x.segment<4>(kOrientation)) - found.X_WC.linear()).norm(), 1e-15);
  EXPECT_EQ(after.x.segment<6>(kVelocity).norm(), 0);
  EXPECT_EQ(after.x.tail<kRobot - kCamera>(), before.robot().tail<kRobot - kCamera>());
  EXPECT_NEAR(after.P(0, 0), 0.01, 1e-16);
  EXPECT_NEAR((after.P.block<4, 4>(kOrientation, kOrientation).trace()), 3 * 0.01 / 4, 1e-16);
  EXPECT_NEAR(after.P(kVelocity, kVelocity), 0.3 * 0.3, 1e-16);
  EXPECT_EQ((after.P.bottomRightCorner<kRobot - kCamera, kRobot - kCamera>()),
            (before.storage_P.bottomRightCorner<kRobot - kCamera, kRobot - kCamera>()));
  EXPECT_EQ((after.P.bottomLeftCorner<kRobot - kCamera, kCamera>().norm()), 0);
}

Stamp at_s(double t) { return Stamp(static_cast<Stamp::rep>(1e9 * t)); }

/// A pose at t, moved along x and turned.
Estimate estimate(double t, double x, double yaw, double sigma = 0.001) {
  return {at_s(t), pose(yaw, {0, 0, 1}, {x, 0, 0}), sigma * sigma * Matrix6d::Identity()};
}

TEST(RelocalizationConfirmer, ImmediatelyConfirmsAPoseThatAgreesWithThePrediction) {
  RelocalizationConfirmer confirmer;
  EXPECT_TRUE(confirmer.confirms(estimate(0, 1, 0.2), estimate(0, 1.002, 0.2), true));
  EXPECT_FALSE(confirmer.confirms(estimate(0, 1, 0.2), estimate(0, 1.1, 0.2), true));
  EXPECT_TRUE(confirmer.confirms(estimate(0, 1, 0.2), estimate(0, 1.1, 0.2, 0.1), true));
}

TEST(RelocalizationConfirmer, ConfirmsAnotherPoseThatMovesAsPredictedForASecond) {
  RelocalizationConfirmer confirmer;
  for (const double t : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0})
    EXPECT_EQ(confirmer.confirms(estimate(t, 2 + 0.2 * t, 0.3 * t), estimate(t, 0.2 * t, 0.2 * t), true),
              t == 1)
        << t;
}

TEST(RelocalizationConfirmer, DoesNotConfirmAPoseFromLandmarksThatMoveWithTheCamera) {
  for (const auto& [speed, rate, plan] : {std::tuple{0.2, 0.0, true}, {0.0, 0.2, true}, {0.0, 0.2, false}}) {
    RelocalizationConfirmer confirmer;
    for (double t = 0; t < 10; t += 0.2)
      EXPECT_FALSE(confirmer.confirms(estimate(t, -2, 0), estimate(t, speed * t, rate * t), plan)) << t;
  }
}

TEST(RelocalizationConfirmer, ComparesNoDistancesWithoutAPlan) {
  RelocalizationConfirmer confirmer;
  EXPECT_FALSE(confirmer.confirms(estimate(0, 2, 0), estimate(0, 0, 0), false));
  EXPECT_TRUE(confirmer.confirms(estimate(1, 2, 0.2), estimate(1, 1, 0.2), false));
}

TEST(Headings, GoAllAroundStartingWithTheMostLikely) {
  Headings headings;
  headings.begin_with(1);
  std::set<int> eighths;
  for (int k = 0; k < 8; ++k) {
    const double turn = headings.next() - 1;
    if (k == 0) {
      EXPECT_EQ(turn, 0);
    }
    eighths.insert((static_cast<int>(std::lround(turn / (std::numbers::pi / 4))) + 8) % 8);
  }
  EXPECT_EQ(eighths.size(), 8U);
}

/// A map of landmarks of known depth, seen by a camera that looks along +x.
struct MapScene {
  MapScene() {
    options.depth.sigma_inverse_1_m = 0.001;
    std::mt19937_64 random(1);
    std::vector<Eigen::Vector2d> occupied;
    while (landmarks.size() < 24) {
      const auto corner = propose_corner(image, occupied, options.vision, random);
      if (!corner) continue;
      occupied.push_back(corner->cast<double>());
      // The depths differ, since a plane would have two poses.
      options.depth.inverse_1_m = 0.2 + 0.1 * static_cast<double>(landmarks.size() % 3);
      landmarks.push_back(*initialize_landmark(image, {}, Stamp(0), *corner, camera, options, kalman));
      landmarks.back().successes = landmarks.back().attempts = 100;
    }
  }
  /// The pose found when the state is turned by `turned` and the search is turned by `turn`.
  std::optional<Estimate> found(const cv::Mat& now, double turned = 0, double turn = 0) {
    State state = kalman.state();
    const Eigen::Isometry3d X_WC = pose(turned, {0, 0, 1}, {0, 0, 0}) * state.X_WC();
    const Eigen::Quaterniond q(X_WC.linear());
    state.storage_x.segment<4>(kOrientation) << q.w(), q.x(), q.y(), q.z();
    return relocalize(now, landmarks, state, turn, camera, 0.1);
  }

  Options options;
  Camera camera{CameraIntrinsics{}};
  cv::Mat image = random_blocks(320, 8, 5);
  Kalman kalman{{looking_ahead(), 1e-8 * RobotMatrix::Identity()}, false};
  std::vector<Landmark> landmarks;
};

TEST(Relocalization, FindsThePoseInTheHeadingThatItSearches) {
  MapScene scene;
  for (const auto& [turned, turn] : {std::pair{0.0, 0.0}, {2.0, -2.0}, {2.0, -1.7}}) {
    const auto found = scene.found(scene.image, turned, turn);
    ASSERT_TRUE(found) << turned << turn;
    EXPECT_LT((found->X_WC.matrix() - scene.kalman.state().X_WC().matrix()).norm(), 0.02);
  }
  EXPECT_FALSE(scene.found(scene.image, 2.0, 0));
}

TEST(Relocalization, DoesNotAcceptAPoseAtWhichMostOfThePredictedLandmarksAreMissing) {
  MapScene scene;
  for (const int present : {10, 20}) {
    cv::Mat now = random_blocks(320, 8, 6);
    for (int i = 0; i < present; ++i) {
      const Eigen::Vector2i at = scene.landmarks[static_cast<std::size_t>(i)].pixel_first.cast<int>();
      const cv::Rect around = cv::Rect(at.x() - 8, at.y() - 8, 17, 17) & cv::Rect(0, 0, 320, 240);
      scene.image(around).copyTo(now(around));
    }
    EXPECT_EQ(scene.found(now).has_value(), present == 20) << present;
  }
}

const synthetic::Recording& walk() {
  static const synthetic::Recording recording = synthetic::recorded(5, 0.12, 15);
  return recording;
}

/// A filter that walks up to a frame, then sees a different place for 1 s and has only its gyro.
Filter lost_filter(int until, const Options::Tracking& tracking) {
  Options options;
  options.tracking = tracking;
  Filter filter(options, synthetic::calibration(), walk().walk().X_WC(0), 1);
  for (int k = 0; k < until + 15; ++k) {
    Observation o = walk().observation(k);
    if (k >= until) {
      cv::flip(o.image, o.image, -1);
      o.accelerometer.clear(), o.plan.reset();
    }
    filter.step(o);
  }
  return filter;
}

/// The distance of the estimate from the true position at a frame, m.
double error_m(const Filter& filter, int frame) {
  const Eigen::Isometry3d X_WC = walk().walk().X_WC(seconds(walk().walk().stamp(frame)));
  return (filter.estimate().X_WC.translation() - X_WC.translation()).norm();
}

TEST(Relocalization, AFilterThatWasCarriedAwayFindsItsTruePose) {
  Options::Tracking tracking;
  tracking.lost_after_s = 0.5;
  Filter filter = lost_filter(60, tracking);
  const Stamp lost_at = walk().walk().stamp(74);
  bool found = false;
  int after = 0;
  for (int k = 20; k < 55; ++k) {  // put down at its pose of frame 20, which is 0.2 m away and rotated
    Observation o = walk().observation(k);
    const Stamp later = lost_at + walk().walk().stamp(k - 19) - o.t;
    o.t += later;
    for (InertialSample& sample : o.gyro) sample.begin += later, sample.end += later;
    o.accelerometer.clear(), o.plan.reset();
    const FrameReport& report = filter.step(o);
    ASSERT_NE(report.health, Health::diverged) << report.cause.value_or("");
    found = found || report.relocalized;
    if (!found) continue;
    EXPECT_EQ(report.health, Health::ok) << k;
    // the map is right within 2 cm, and matches of relocalization are on the raw pixel grid
    if (++after > 3) {
      EXPECT_LT(error_m(filter, k), 0.05) << k;
    }
  }
  EXPECT_TRUE(found);
  EXPECT_GT(after, 5);
}

/// Something textured that covers the view and moves with the camera, as seen by a noisy camera.
cv::Mat cover(int frame) {
  cv::RNG random(7);
  cv::Mat picture(240, 320, CV_8UC1), noise(240, 320, CV_8UC1);
  random.fill(picture, cv::RNG::UNIFORM, 0, 200);
  cv::RNG(static_cast<std::uint64_t>(100 + frame)).fill(noise, cv::RNG::UNIFORM, 0, 5);
  return picture + noise;
}

TEST(Relocalization, AFilterWithACoveredViewContinuesAtItsPredictionButNotAfterALossOfGyroAndPlanToo) {
  for (const bool covered : {true, false}) {  // false: without any input
    Options options;
    options.tracking.lost_after_s = 0.5;
    Filter filter(options, synthetic::calibration(), walk().walk().X_WC(0), 1);
    bool lost = false, found = false;
    const int from = covered ? 40 : 30, to = from + 20;
    for (int k = 0; k < 75; ++k) {
      Observation o = walk().observation(k);
      if (k >= from && k < to)
        o = covered ? Observation{o.t, cover(k), o.gyro, o.accelerometer, o.plan, {}, {}, {}, {}}
                    : Observation{o.t, {}, {}, {}, {}, {}, {}, {}, {}};
      const FrameReport& report = filter.step(o);
      const bool is_lost = report.health == Health::lost;
      found = found || report.relocalized;
      EXPECT_TRUE(is_lost || found || !lost || covered) << k << " matches near the prediction do not count";
      lost = lost || is_lost;
      EXPECT_FALSE(covered && (report.relocalized || (is_lost && k >= to + 3)))
          << k << report.cause.value_or("");
      if (covered || (lost && !is_lost)) {
        EXPECT_LT(error_m(filter, k), 0.05) << covered << k;
      }
    }
    EXPECT_TRUE(lost);
    EXPECT_EQ(found, !covered);
  }
}

TEST(Relocalization, AFilterThatKnowsItsPoseStartsLandmarksOnNewGroundBehindACover) {
  const synthetic::Recording turning = synthetic::recorded(5, 0.6, 15);
  const synthetic::Walk& truth = turning.walk();
  Options options;
  options.tracking.lost_after_s = 0.3, options.tracking.give_up_s = 2.5;
  Filter filter(options, synthetic::calibration(), truth.X_WC(0), 1);
  const int from = 30, to = 60;  // meanwhile, the robot turns by 86 degrees
  bool lost = false;
  for (int k = 0; k < 75; ++k) {
    Observation o = turning.observation(k);
    if (k >= from && k < to) cover(k).rowRange(0, 192).copyTo(o.image.rowRange(0, 192));
    const Health health = filter.step(o).health;
    lost = lost || health == Health::lost;
    EXPECT_TRUE(k < to + 5 || health == Health::ok) << k;
    const Eigen::Vector3d p_WC = truth.X_WC(seconds(truth.stamp(k))).translation();
    EXPECT_LT((filter.estimate().X_WC.translation() - p_WC).norm(), 0.05) << k;
  }
  EXPECT_TRUE(lost);
}

TEST(Relocalization, LandmarksOnACoverAreNotUsedAndAFilterThatKnowsItsPoseDoesNotGiveUp) {
  const synthetic::Recording turning = synthetic::recorded(5, 0.6, 15);
  const synthetic::Walk& truth = turning.walk();
  Options options;
  options.tracking.lost_after_s = options.tracking.give_up_s = 0.5;
  Filter filter(options, synthetic::calibration(), truth.X_WC(0), 1);
  const int from = 20, to = 60;  // meanwhile, the robot turns by 115 degrees
  int used = 0, mapped = 0;
  for (int k = 0; k < 75; ++k) {
    const bool covered = k >= from && k < to;
    Observation o = turning.observation(k);
    if (covered) o.image = cover(k);
    const FrameReport& report = filter.step(o);
    used += covered ? report.accepted : 0;
    EXPECT_FALSE(report.relocalized) << k << " its pose is known";
    EXPECT_EQ(report.health, k < from + 7 || k >= to + 6 ? Health::ok : report.health) << k;
    EXPECT_TRUE(!covered || k < from + 8 || report.health == Health::lost) << k;
    const Eigen::Isometry3d X_WC = truth.X_WC(seconds(truth.stamp(k)));
    const Eigen::AngleAxisd turned(filter.estimate().X_WC.linear().transpose() * X_WC.linear());
    EXPECT_LT(std::abs(turned.angle()), 0.02) << k;
  }
  for (const MapPoint& point : filter.map())
    mapped += point.initialized >= truth.stamp(from) && point.initialized < truth.stamp(to) ? 1 : 0;
  EXPECT_LE(used, 2);  // by chance
  EXPECT_EQ(mapped, 0);
}

TEST(Relocalization, AFilterThatDoesNotRecognizeItsMapDiverges) {
  Options::Tracking tracking;
  tracking.lost_after_s = tracking.give_up_s = 0.3;
  Filter filter = lost_filter(40, tracking);
  const Observation o = walk().observation(60);
  EXPECT_EQ(filter.step(o).health, Health::diverged);
  EXPECT_NE(filter.step(o).cause.value().find("tracking lost"), std::string::npos);
}

}  // namespace
}  // namespace slam
