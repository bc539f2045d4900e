#include "slam/map.h"

#include <gtest/gtest.h>

#include <set>

#include "slam/active_search.h"
#include "tests/slam/synthetic_room.h"

namespace slam {
namespace {

/// Blurred-looking noise of 8 px blocks: corners everywhere.
cv::Mat blocks(std::uint64_t seed) {
  cv::Mat image(240, 320, CV_8UC1);
  std::mt19937_64 random(seed);
  for (int row = 0; row < 240; row += 8)
    for (int column = 0; column < 320; column += 8)
      image(cv::Rect(column, row, 8, 8)).setTo(cv::Scalar(static_cast<double>(random() % 256)));
  return image;
}

Kalman looking_ahead() {
  RobotVector x = RobotVector::Zero();
  x.segment<3>(kPosition) << 0.3, -0.2, 1.4;
  x.segment<4>(kOrientation) << 0.5, -0.5, 0.5, -0.5;  // z ahead along +x
  return Kalman(x, 1e-4 * RobotMatrix::Identity(), true);
}

/// A map of `wanted` new landmarks.
struct Begun {
  explicit Begun(int wanted, std::uint64_t seed = 1) : map(seed) {
    std::vector<Eigen::Vector2d> taken;
    begun = map.begin(blocks(5), Stamp(7), taken, wanted, camera, options, kalman);
  }
  std::vector<int> pruned() {
    std::vector<int> deleted;
    map.prune(kalman, deleted);
    return deleted;
  }
  Options options;
  Camera camera{CameraIntrinsics{}};
  Kalman kalman = looking_ahead();
  Map map;
  int begun = 0;

  Vector6d parameters(std::size_t i) const {
    return kalman.state().storage_x.segment<6>(map.landmarks()[i].at);
  }
  Eigen::Vector2d pixel(std::size_t i) const {
    const State& s = kalman.state();
    const Landmark& landmark = map.landmarks()[i];
    const Parameters y = s.storage_x.segment(landmark.at, landmark.size());
    return camera.project(direction(landmark.kind, y, s.position(), s.orientation()).h_C)->pixel;
  }
  /// Makes the inverse depth of a landmark well known, as many sights from many places would.
  void know_depth(std::size_t i, double value) {
    Measurement m(1);
    m.H_landmark = Eigen::RowVectorXd::Unit(6, 5);
    m.landmark_at = map.landmarks()[i].at;
    m.R(0, 0) = 1e-8;
    m.innovation(0) = value - parameters(i)(5);
    Joint joint;
    kalman.stack({m}, joint);
    ASSERT_TRUE(kalman.update(joint));
  }
};

TEST(Map, BeginsAsManyLandmarksAsWantedApartFromEachOtherAndFromThoseTaken) {
  Begun b(8);
  ASSERT_EQ(b.begun, 8);
  ASSERT_EQ(b.kalman.state().size, kRobot + 48);
  std::vector<Eigen::Vector2d> pixels;
  for (std::size_t i = 0; i < 8; ++i) pixels.push_back(b.pixel(i));
  const int more = b.map.begin(blocks(5), Stamp(8), pixels, 4, b.camera, b.options, b.kalman);
  ASSERT_EQ(pixels.size(), b.map.landmarks().size());
  for (std::size_t i = 8; i < pixels.size(); ++i)
    EXPECT_LT((pixels[i] - b.pixel(i)).norm(), 1e-9);  // rounding
  EXPECT_LE(more, 4);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE((pixels[i] - pixels[j]).norm(), 20 - 1e-9) << i << ' ' << j;
}

TEST(Map, BeginsNothingInAnImageWithoutCorners) {
  Begun b(0);
  const cv::Mat grey(240, 320, CV_8UC1, cv::Scalar(128));
  std::vector<Eigen::Vector2d> taken;
  EXPECT_EQ(b.map.begin(grey, Stamp(1), taken, 5, b.camera, b.options, b.kalman), 0);
  EXPECT_EQ(b.kalman.state().size, kRobot);
}

TEST(Map, IsTheSameFromTheSameSeedAndAnotherFromAnother) {
  const Begun a(6, 1), same(6, 1), other(6, 2);
  EXPECT_EQ(a.kalman.state().x(), same.kalman.state().x());
  EXPECT_EQ(a.kalman.state().P(), same.kalman.state().P());
  EXPECT_NE(a.parameters(0), other.parameters(0));
}

TEST(Map, DeletesWhatWasFoundLessThanEverySecondTimeInTenSearchesAndNothingElse) {
  Begun b(4);
  const auto search = [&](std::size_t i, int attempts, int successes) {
    for (int k = 0; k < attempts; ++k) b.map.count(i, k < successes);
  };
  search(0, 9, 0);   // not yet searched for often enough
  search(1, 10, 5);  // just good enough
  search(2, 10, 4);  // not
  search(3, 40, 19);
  const int two = b.map.landmarks()[2].id, three = b.map.landmarks()[3].id;
  const std::vector<int> deleted = b.pruned();
  EXPECT_EQ(std::set<int>(deleted.begin(), deleted.end()), (std::set<int>{two, three}));
  EXPECT_EQ(b.map.landmarks().size(), 2u);
}

TEST(Map, DeletesALandmarkThatIsSurelyBehindItsFirstSight) {
  Begun b(3);
  b.know_depth(1, -0.01);
  const int behind = b.map.landmarks()[1].id;
  EXPECT_EQ(b.pruned(), std::vector<int>{behind});
}

TEST(Map, DeletingAndConvertingLeaveEveryOtherLandmarkItsOwnParameters) {
  Begun b(5);
  for (const std::size_t i : {1u, 3u}) b.know_depth(i, 0.25);
  std::vector<Eigen::Vector2d> before;
  for (std::size_t i = 0; i < 5; ++i) before.push_back(b.pixel(i));
  b.map.convert(0.1, b.kalman);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(std::holds_alternative<Point>(b.map.landmarks()[i].kind), i == 1 || i == 3) << i;
    EXPECT_LT((b.pixel(i) - before[i]).norm(), 1e-9) << i;
  }
  for (int k = 0; k < 10; ++k) b.map.count(1, false);
  ASSERT_EQ(b.pruned().size(), 1u);
  EXPECT_EQ(b.kalman.state().size, kRobot + 6 + 6 + 3 + 6);
  for (std::size_t i = 1; i < 4; ++i) EXPECT_LT((b.pixel(i) - before[i + 1]).norm(), 1e-9) << i;
}

TEST(Map, TheDirectionOfANewLandmarkIsAsCertainAsItsFirstSight) {
  const Begun begun(1);
  const Eigen::MatrixXd P = begun.kalman.state().P();
  const int at = begun.map.landmarks()[0].at;
  Options rough;
  rough.vision.sigma_first_px = 1;
  Map map(1);
  Kalman kalman = looking_ahead();
  std::vector<Eigen::Vector2d> taken;
  map.begin(blocks(5), Stamp(7), taken, 1, begun.camera, rough, kalman);
  const double more = kalman.state().P()(at + 4, at + 4) - P(at + 4, at + 4);
  const double sigma = begun.camera.sigma(begun.pixel(0), 1) / begun.camera.intrinsics().fu_px;
  EXPECT_GT(more, 0.2 * sigma * sigma);
  EXPECT_LT(more, 1.5 * sigma * sigma);
}

TEST(Map, AnUncertainDepthIsNotConverted) {
  Begun b(3);
  b.map.convert(0.1, b.kalman);
  for (const Landmark& landmark : b.map.landmarks())
    EXPECT_TRUE(std::holds_alternative<InverseDepth>(landmark.kind));
}

TEST(Map, AConvertedLandmarkIsPredictedAtTheSamePixelWithTheSameCovariance) {
  Begun b(3);
  for (std::size_t i = 0; i < 3; ++i) b.know_depth(i, 0.25);
  const auto before = predict_view(b.kalman, b.map.landmarks(), b.camera, 1);
  b.map.convert(0.1, b.kalman);
  const auto after = predict_view(b.kalman, b.map.landmarks(), b.camera, 1);
  ASSERT_EQ(before.size(), 3u);
  ASSERT_EQ(after.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(std::holds_alternative<Point>(b.map.landmarks()[i].kind));
    EXPECT_LT((after[i].pixel - before[i].pixel).norm(), 1e-9);
    EXPECT_LT((after[i].S - before[i].S).norm(), 1e-3 * before[i].S.norm());  // heading constrained anew
  }
}

/// The camera's covariance, and that of landmark i alone.
Eigen::MatrixXd covariance_of(const Begun& begun, std::size_t i) {
  const Landmark& landmark = begun.map.landmarks()[i];
  const int at = landmark.at, size = landmark.size();
  return begun.kalman.state().P().block(at, at, size, size);
}

/// Puts the camera elsewhere, nothing else being touched.
void move(Kalman& kalman, const Eigen::Vector3d& by) {
  RobotVector x = kalman.state().storage_x.head<kRobot>();
  x.segment<3>(kPosition) += by;
  kalman.predict(x, RobotMatrix::Identity(), RobotMatrix::Zero());
}

TEST(Map, ALandmarkIsLessCertainAfterItsViewHasChangedAndNotAfterSwaying) {
  Begun begun(1);
  begun.options.vision.sigma_view_px = 0.5;
  const Landmark& landmark = begun.map.landmarks()[0];
  const double distance =
      (position(landmark.kind, Parameters(begun.parameters(0))) - begun.kalman.state().position()).norm();
  const Eigen::MatrixXd before = covariance_of(begun, 0);
  const Eigen::Vector3d aside(0, 0.01 * distance, 0);
  move(begun.kalman, aside);
  begun.map.seen_anew(0, begun.camera, begun.options, begun.kalman);
  move(begun.kalman, -aside);
  begun.map.seen_anew(0, begun.camera, begun.options, begun.kalman);
  EXPECT_EQ(covariance_of(begun, 0), before);
  move(begun.kalman, Eigen::Vector3d(0, 0.04 * distance, 0));
  begun.map.seen_anew(0, begun.camera, begun.options, begun.kalman);
  begun.map.seen_anew(0, begun.camera, begun.options, begun.kalman);  // once for the same view
  Eigen::MatrixXd more = covariance_of(begun, 0) - before;
  const double angle = 0.5 / begun.camera.intrinsics().fu_px;
  EXPECT_NEAR(more(3, 3), 0.04 * angle * angle, 0.002 * angle * angle);  // the distance is another now
  EXPECT_NEAR(more(4, 4), more(3, 3), 1e-15);
  more(3, 3) = more(4, 4) = 0;
  EXPECT_LT(more.norm(), 1e-15);
}

TEST(Map, APointIsLessCertainAlikeInSpace) {
  Begun begun(1);
  begun.options.vision.sigma_view_px = 0.5;
  begun.know_depth(0, 0.5);
  begun.map.convert(1e9, begun.kalman);
  ASSERT_EQ(begun.map.landmarks()[0].size(), Point::kSize);
  const Eigen::MatrixXd before = covariance_of(begun, 0);
  move(begun.kalman, Eigen::Vector3d(0.2, 0, 0));
  begun.map.seen_anew(0, begun.camera, begun.options, begun.kalman);
  const Eigen::MatrixXd more = covariance_of(begun, 0) - before;
  EXPECT_LT((more - more(0, 0) * Eigen::Matrix3d::Identity()).norm(), 1e-12 * more(0, 0) + 1e-18);
  const double distance =
      (Eigen::Vector3d(begun.kalman.state().storage_x.segment<3>(begun.map.landmarks()[0].at)) -
       begun.kalman.state().position())
          .norm();
  const double sigma = 0.5 / begun.camera.intrinsics().fu_px * distance;
  EXPECT_NEAR(more(0, 0), sigma * sigma * 0.2 / distance, 1e-3 * more(0, 0));
}

}  // namespace
}  // namespace slam
