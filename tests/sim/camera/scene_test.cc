#include "sim/camera/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "tests/sim/physics/test_worlds.h"

namespace sim::camera {
using namespace physics;
namespace {

const Pinhole kView{240, 180, 120, -1, -0.75, 0, 0, {}};

Eigen::Isometry3d looking(double yaw) {
  Eigen::Matrix3d R_level;  // optical axes of a camera that looks along x
  R_level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Eigen::Translation3d(0.9, 0.15, 1.3) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::Isometry3d(Eigen::AngleAxisd(R_level));
}

// Two planes that face the camera, 2 m and 3 m ahead, and a sheet that shows it its back.
const char kSheets[] =
    "<visual><headlight ambient='1 1 1' diffuse='0 0 0'/></visual><worldbody>"
    "<geom type='plane' size='9 9 1' pos='3.9 0.15 1.3' xyaxes='0 -1 0 0 0 1' rgba='0.4 0.4 0.4 1'/>"
    "<geom type='plane' size='0.5 0.5 1' pos='2.9 0.15 1.3' xyaxes='0 -1 0 0 0 1' rgba='0.8 0.8 0.8 1'/>"
    "<geom type='plane' size='9 9 1' pos='1.9 0.15 1.3' xyaxes='0 1 0 0 0 1' rgba='0.2 0.2 0.2 1'/>"
    "<geom type='sphere' size='0.3' pos='1.9 0.15 1.3' rgba='1 1 1 0'/></worldbody>";

}  // namespace

TEST(Scene, TheNearerSurfaceHidesTheFartherAndBacksAndTransparentThingsAreNotSeen) {
  const Model model = SmallModel(kSheets).load();
  const Data data(mj_makeData(model.get()));
  mj_kinematics(model.get(), data.get());
  Scene scene(*model, {kView}, 0, 1, Channels::grey);
  const cv::Mat1b picture = scene.draw(*data, looking(0));
  for (int row = 0; row < picture.rows; ++row)
    for (int column = 0; column < picture.cols; ++column) {
      const double across = std::abs(column - 119.5), down = std::abs(row - 89.5);  // edges: 0.5 / 2 * 120 px
      ASSERT_EQ(picture(row, column), across < 30 && down < 30 ? 204 : 102) << row << " " << column;
    }
}

// Two roundings of colours against one of their brightness, and eight bits of a texel's fraction for each.
TEST(Scene, GreyIsTheBrightnessOfTheColorsWithinTwoLevels) {
  const Model model = load_model("hrp2", "office", std::string(GAITSLAM_SOURCE_DIR) + "/models");
  const Data data(mj_makeData(model.get()));
  stand_on_circle(*data, 0);
  mj_kinematics(model.get(), data.get());
  Scene grey(*model, {kView}, 0, 1, Channels::grey), colored(*model, {kView}, 0, 1, Channels::rgb);
  for (const double yaw : {0.0, 1.5, 3.0, 4.5})
    for (const float light : {1.0f, 0.3f}) {
      cv::Mat expected;
      cv::cvtColor(colored.draw(*data, looking(yaw), light), expected, cv::COLOR_RGB2GRAY);
      const cv::Mat found = grey.draw(*data, looking(yaw), light);
      EXPECT_LE(cv::norm(found, expected, cv::NORM_INF), 2) << yaw << " " << light;
      EXPECT_GT(cv::norm(found, cv::Mat1b(found.size(), uchar(cv::mean(found)[0])), cv::NORM_L1) /
                    double(found.total()),
                light * 10);  // levels of contrast: there is something to compare
    }
}

TEST(Scene, WhatIsMaskedIsBlackAndTheRestAsBefore) {
  const Model model = SmallModel(kSheets).load();
  const Data data(mj_makeData(model.get()));
  mj_kinematics(model.get(), data.get());
  Pinhole masked = kView;
  masked.unsampled = {{0, 0, 40, 30}, {200, 100, 40, 80}};
  Scene scene(*model, {kView}, 0, 1, Channels::grey), with_mask(*model, {masked}, 0, 1, Channels::grey);
  cv::Mat expected = scene.draw(*data, looking(0));
  for (const cv::Rect& area : masked.unsampled) expected(area) = 0;
  EXPECT_EQ(cv::norm(with_mask.draw(*data, looking(0)), expected, cv::NORM_INF), 0);
}

}  // namespace sim::camera
