#include "sim/camera/shutter.h"

#include <gtest/gtest.h>

#include "sim/physics/model.h"

namespace sim::camera {
using namespace physics;
namespace {

CameraOptions camera(double exposure_s, double readout_s, int subframes) {
  CameraOptions options;
  options.exposure_s = exposure_s, options.readout_s = readout_s, options.subframes = subframes;
  return options;
}

// The moment a row sees on average, by the shares of the pictures it is made of.
double mean_moment(const Shutter& shutter, int row) {
  double sum = 0;
  for (int i = 0; i < int(shutter.moments().size()); ++i)
    sum += shutter.moments()[std::size_t(i)] * double(shutter.shares()(i, row));
  return sum;
}

}  // namespace

TEST(Shutter, ThatTakesNoTimeIsOnePictureAtTheStamp) {
  const Shutter shutter(camera(0, 0, 8));
  EXPECT_EQ(shutter.moments(), std::vector<double>{0});
  EXPECT_EQ(shutter.lead().count(), 0);
  const cv::Mat1b picture(240, 320, uchar(77));
  EXPECT_EQ(shutter.expose({picture}).data, picture.data);
}

TEST(Shutter, EachRowGathersAllItsLightAroundItsOwnMoment) {
  for (auto [exposure, readout] : {std::pair(0.008, 0.0), std::pair(0.0, 0.02), std::pair(0.01, 0.016)}) {
    const Shutter shutter(camera(exposure, readout, 9));
    for (int row = 0; row < 240; ++row) {
      float sum = 0;
      for (int i = 0; i < 9; ++i) sum += shutter.shares()(i, row);
      ASSERT_NEAR(sum, 1, 1e-5);
      ASSERT_NEAR(mean_moment(shutter, row), readout * ((row + 0.5) / 240 - 0.5),
                  1e-8);  // rounding of floats
    }
  }
}

TEST(Shutter, HasClosedWhenItsLeadIsOver) {
  EXPECT_EQ(Shutter(camera(0.01, 0.016, 9)).lead().count(), 13);
  EXPECT_EQ(Shutter(camera(0.005, 0, 9)).lead().count(), 3);
}

// A light that grows evenly from 0 to 200 during the exposure leaves 100; a row that is read a quarter of the
// span earlier sees 50 less.
TEST(Shutter, RowsOfAGrowingLightAreAsBrightAsTheirMomentsSay) {
  const Shutter blur(camera(0.01, 0, 9)), rolling(camera(0, 0.01, 9));
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < 9; ++i) pictures.push_back(cv::Mat1b(240, 4, uchar(25 * i)));
  const cv::Mat1b blurred = blur.expose(pictures), rolled = rolling.expose(pictures);
  for (int row = 0; row < 240; ++row) {
    ASSERT_EQ(blurred(row, 2), 100);
    ASSERT_NEAR(rolled(row, 2), 200 * (row + 0.5) / 240, 0.51);  // rounded to whole levels
  }
}

TEST(RecentMotion, IsInterpolatedEvenlyAndTurnsTheShortWay) {
  const std::filesystem::path models = std::filesystem::path(GAITSLAM_SOURCE_DIR) / "models";
  const Model model = load_model("hrp2", "floor", models);
  const Data data(mj_makeData(model.get()));
  RecentMotion motion(std::chrono::milliseconds(3));
  for (int ms = 0; ms < 10; ++ms) {
    const double yaw = 0.02 * ms;
    data->qpos[0] = 0.5 * ms;
    data->qpos[3] = std::cos(yaw / 2), data->qpos[6] = std::sin(yaw / 2);
    motion.add(std::chrono::milliseconds(ms), *model, *data);
  }
  const Eigen::VectorXd q = motion.at(0.00725, *model);
  EXPECT_NEAR(q[0], 3.625, 1e-12);
  EXPECT_NEAR(2 * std::atan2(q[6], q[3]), 0.145, 1e-12);
  EXPECT_NEAR(motion.at(0.009, *model)[0], 4.5, 1e-12);
  EXPECT_NEAR(motion.at(0.1, *model)[0], 4.5, 1e-12);  // nothing later is known
  EXPECT_NEAR(motion.at(0.0, *model)[0], 2.5, 0.51);   // what is older than it keeps is gone
}

}  // namespace sim::camera
