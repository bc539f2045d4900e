#include "sim/world/scene.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <string>

#include "tools/benchmarks/corner_error.h"

namespace sim::world {
namespace {

const Pinhole kView{240, 180, 120, -1, -0.75, 0, 0, {}};

Eigen::Isometry3d looking(double yaw) {
  Eigen::Matrix3d R_level;  // optical axes of a camera that looks along x
  R_level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Eigen::Translation3d(0.9, 0.15, 1.3) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::Isometry3d(Eigen::AngleAxisd(R_level));
}

}  // namespace

// Two roundings of colours against one of their brightness, and eight bits of a texel's fraction for each.
TEST(Scene, GreyIsTheBrightnessOfTheColoursWithinTwoLevels) {
  const Model model = load_model("hrp2", "office", std::string(GAITSLAM_SOURCE_DIR) + "/models");
  const Data data(mj_makeData(model.get()));
  stand_on_circle(*data, 0);
  mj_kinematics(model.get(), data.get());
  Scene grey(*model, {kView}, 0, 1, Channels::grey), coloured(*model, {kView}, 0, 1, Channels::rgb);
  for (const double yaw : {0.0, 1.5, 3.0, 4.5})
    for (const float light : {1.0f, 0.3f}) {
      cv::Mat expected;
      cv::cvtColor(coloured.draw(*data, looking(yaw), light), expected, cv::COLOR_RGB2GRAY);
      const cv::Mat found = grey.draw(*data, looking(yaw), light);
      EXPECT_LE(cv::norm(found, expected, cv::NORM_INF), 2) << yaw << " " << light;
      EXPECT_GT(cv::norm(found, cv::Mat1b(found.size(), uchar(cv::mean(found)[0])), cv::NORM_L1) /
                    double(found.total()),
                light * 10);  // levels of contrast: there is something to compare
    }
}

}  // namespace sim::world
