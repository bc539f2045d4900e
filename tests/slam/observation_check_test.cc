#include "slam/tracking_monitor.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

TEST(ObservationCheck, NamesTheMalformationAndAcceptsWhatIsAbsent) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Observation o;
  EXPECT_EQ(malformation(o, {}), "");
  o.image = random_blocks(320, 8, 1);
  o.gyro = o.accelerometer = {{Stamp(0), Stamp(5), {1, 2, 3}}};
  o.plan = PlannedMotion{};
  EXPECT_EQ(malformation(o, {}), "");
  Observation bad = o;
  bad.image = random_blocks(300, 8, 1);
  EXPECT_EQ(malformation(bad, {}), "its image is not 8-bit gray of the camera's size");
  bad = o;
  bad.image = cv::Mat(240, 320, CV_8UC3, cv::Scalar(0));
  EXPECT_EQ(malformation(bad, {}), "its image is not 8-bit gray of the camera's size");
  bad = o;
  bad.accelerometer[0].value.y() = nan;
  EXPECT_EQ(malformation(bad, {}), "an inertial reading is not finite");
  bad = o;
  bad.gyro[0].end = Stamp(-1);
  EXPECT_EQ(malformation(bad, {}), "an inertial reading is not finite");
  bad = o;
  bad.plan->p_CF.x() = nan;
  EXPECT_EQ(malformation(bad, {}), "its plan is not finite");
}

TEST(ImageCheck, NamesFlatAndRepeatedImages) {
  ImageCheck check;
  const cv::Mat image = random_blocks(320, 8, 1), other = random_blocks(320, 8, 2);
  const auto reason = [&](const cv::Mat& now) { return check.defect(now, false).reason; };
  EXPECT_EQ(reason(image), "");
  EXPECT_EQ(reason(image.clone()), "the image is the last one again");
  EXPECT_EQ(reason(other), "");
  EXPECT_EQ(reason(cv::Mat(240, 320, CV_8UC1, cv::Scalar(3))), "the image is flat");
  EXPECT_EQ(reason(other), "");
}

TEST(ImageCheck, ARepeatedImageBlindsUnlessTheCameraIsKnownToStandStill) {
  const cv::Mat image = random_blocks(320, 8, 1);
  for (const bool still : {true, false}) {
    ImageCheck check;
    check.defect(image, still);
    for (int k = 0; k < 20; ++k) EXPECT_EQ(check.defect(image, still).blinds, !still) << k;
  }
}

TEST(ImageCheck, ARepeatedImageOfACameraWithNoiseBlindsAlsoWhereItStandsStill) {
  ImageCheck check;
  for (std::uint64_t k = 0; k < 6; ++k) EXPECT_EQ(check.defect(random_blocks(320, 1, k), true).reason, "");
  EXPECT_TRUE(check.defect(random_blocks(320, 1, 5), true).blinds);
}

TEST(ImageCheck, FlatImagesBlind) {
  ImageCheck check;
  EXPECT_TRUE(check.defect(cv::Mat(240, 320, CV_8UC1, cv::Scalar(0)), true).blinds);
}

TEST(StandsStill, IsKnownOnlyWherePlanAndGyroBothSaySo) {
  Observation o;
  o.gyro = {{Stamp(0), Stamp(5), {0.01, 0, -0.01}}, {Stamp(5), Stamp(10), {-0.01, 0, 0.01}}};
  PlannedVelocity stands{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  PlannedVelocity walks = stands;
  walks.velocity.x() = 0.1;
  const Options options;
  EXPECT_TRUE(stands_still(o, stands, options));
  EXPECT_FALSE(stands_still(o, walks, options));
  EXPECT_FALSE(stands_still(o, std::nullopt, options));
  Options without_plan, without_gyro;
  without_plan.plan_velocity.enabled = without_gyro.gyro.enabled = false;
  EXPECT_FALSE(stands_still(o, stands, without_plan));
  EXPECT_FALSE(stands_still(o, stands, without_gyro));
  for (InertialSample& reading : o.gyro) reading.value.y() = 0.2;
  EXPECT_FALSE(stands_still(o, stands, options));
  o.gyro.clear();
  EXPECT_FALSE(stands_still(o, stands, options));
}

}  // namespace
}  // namespace slam
