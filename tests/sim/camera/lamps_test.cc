#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "sim/camera/shapes.h"
#include "sim/physics/model.h"
#include "tests/sim/physics/small_model.h"

namespace sim::camera {
using namespace physics;
namespace {

using Eigen::Vector3f;

const std::string kHeadlight =
    "<visual><headlight ambient='0.2 0.2 0.2' diffuse='0.9 0.9 0.9' specular='1 1 1'/></visual>";

Lamps lamps(const std::string& lights, const std::string& robot = "<worldbody/>") {
  const Model model = SmallModel(kHeadlight + "<worldbody>" + lights + "</worldbody>", robot).load();
  const Data data(mj_makeData(model.get()));
  mj_kinematics(model.get(), data.get());
  mj_camlight(model.get(), data.get());
  return Lamps(*model, *data);
}

}  // namespace

// By hand: 0.2 of the headlight, 0.1 ambient, 0.5 cos(60 degrees) of the lamp; the lamp from below adds
// nothing, nor does what of the headlight would move with the head.
TEST(Lamps, ASurfaceHasTheLightOfThoseInFrontOfIt) {
  const Lamps two = lamps(
      "<light directional='true' dir='-0.8660254 0 -0.5' ambient='0.1 0.1 0.1' diffuse='0.5 0.4 0.3'/>"
      "<light directional='true' dir='0 0 1' diffuse='1 1 1'/>");
  const Paint paint{{1, 0.5f, 0.1f}, 0.1f};
  EXPECT_TRUE(two.lit(paint, Vector3f::UnitZ(), 1).isApprox(Vector3f(0.65f, 0.3f, 0.055f), 1e-5f));
  EXPECT_TRUE(two.lit(paint, Vector3f::UnitZ(), 0.5f).isApprox(Vector3f(0.375f, 0.175f, 0.0325f), 1e-5f));
  EXPECT_EQ(two.lit({{1, 1, 1}, 2}, Vector3f::UnitZ(), 1), Vector3f(1, 1, 1));
}

TEST(Lamps, WhatIsNotTheSameFromEverywhereIsRefused) {
  EXPECT_THROW(lamps("<light pos='0 0 3' dir='0 0 -1'/>"), std::invalid_argument);
  EXPECT_THROW(lamps("",
                     "<worldbody><body><freejoint/><geom size='1'/>"
                     "<light directional='true' dir='0 0 -1'/></body></worldbody>"),
               std::invalid_argument);
}

TEST(Paint, IsOfTheMaterialUnlessTheGeomHasAColorOfItsOwn) {
  const Model model = SmallModel(
                          "<asset><material name='red' rgba='1 0 0 1' emission='0.5'/></asset><worldbody>"
                          "<geom size='1' material='red'/><geom size='1' rgba='0 1 0 1'/></worldbody>")
                          .load();
  EXPECT_EQ(paint_of(*model, 0).rgb, Vector3f(1, 0, 0));
  EXPECT_EQ(paint_of(*model, 0).emission, 0.5f);
  EXPECT_EQ(paint_of(*model, 1).rgb, Vector3f(0, 1, 0));
  EXPECT_EQ(paint_of(*model, 1).emission, 0);
}

}  // namespace sim::camera
