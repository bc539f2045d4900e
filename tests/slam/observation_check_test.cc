#include "slam/observation_check.h"

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
  EXPECT_EQ(malformation(bad, {}), "its image is not 8-bit grey of the camera's size");
  bad = o;
  bad.image = cv::Mat(240, 320, CV_8UC3, cv::Scalar(0));
  EXPECT_EQ(malformation(bad, {}), "its image is not 8-bit grey of the camera's size");
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
  EXPECT_EQ(check.defect(image), "");
  EXPECT_EQ(check.defect(image.clone()), "the image is the last one again");
  EXPECT_EQ(check.defect(other), "");
  EXPECT_EQ(check.defect(cv::Mat(240, 320, CV_8UC1, cv::Scalar(3))), "the image is flat");
  EXPECT_EQ(check.defect(other), "");
}

}  // namespace
}  // namespace slam
