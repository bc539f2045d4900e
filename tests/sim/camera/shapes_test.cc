#include "sim/camera/shapes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/physics/model.h"
#include "tests/sim/physics/test_worlds.h"

namespace sim::camera {
using namespace physics;
namespace {

using Eigen::Vector2f, Eigen::Vector3f;

GeomMesh mesh_of(const std::string& geom, const std::string& assets = "") {
  return geom_mesh(*SmallModel("<asset>" + assets + "</asset><worldbody>" + geom + "</worldbody>").load(), 0);
}

// Volume of a closed surface, by the divergence theorem; negative if triangles face inwards.
double volume(const GeomMesh& mesh) {
  double sum = 0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto p = [&](std::size_t corner) { return mesh.vertices[mesh.indices[i + corner]].p; };
    sum += double(p(0).dot(p(1).cross(p(2)))) / 6;
  }
  return sum;
}

}  // namespace

// Round shapes are 20-sided prisms and less: a circle has 20/(2 pi) sin(2 pi/20) = 0.984 of its area; a
// sphere's stacks of 30 degrees take 8 % more.
TEST(GeomMesh, EnclosesTheVolumeOfItsShape) {
  constexpr double pi = std::numbers::pi;
  const struct {
    const char* geom;
    double volume, least_part;
  } shapes[] = {{"<geom type='box' size='0.1 0.2 0.3'/>", 8 * 0.1 * 0.2 * 0.3, 0.9999},
                {"<geom type='cylinder' size='0.2 0.5'/>", pi * 0.04 * 1, 0.98},
                {"<geom type='sphere' size='0.3'/>", 4 * pi / 3 * 0.027, 0.9},
                {"<geom type='ellipsoid' size='0.1 0.2 0.3'/>", 4 * pi / 3 * 0.006, 0.9},
                {"<geom type='capsule' size='0.1 0.4'/>", pi * 0.01 * 0.8 + 4 * pi / 3 * 0.001, 0.95}};
  for (const auto& shape : shapes) {
    const double found = volume(mesh_of(shape.geom));
    EXPECT_GT(found, shape.least_part * shape.volume) << shape.geom;
    EXPECT_LT(found, 1.0001 * shape.volume) << shape.geom;
  }
}

// A facet of 18 by 30 degrees leans from the normals at its corners by up to half its diagonal, 17 degrees;
// an ellipsoid of 1 : 3 stretches that.
TEST(GeomMesh, NormalsAreThoseOfTheTriangles) {
  for (const char* geom :
       {"<geom type='box' size='0.1 0.2 0.3'/>", "<geom type='cylinder' size='0.2 0.5'/>",
        "<geom type='sphere' size='0.3'/>", "<geom type='capsule' size='0.1 0.4'/>",
        "<geom type='ellipsoid' size='0.1 0.2 0.3'/>", "<geom type='plane' size='1 2 1'/>"}) {
    const GeomMesh mesh = mesh_of(geom);
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      const std::array corners{mesh.vertices[mesh.indices[i]], mesh.vertices[mesh.indices[i + 1]],
                               mesh.vertices[mesh.indices[i + 2]]};
      const Vector3f facet = (corners[1].p - corners[0].p).cross(corners[2].p - corners[0].p).normalized();
      for (const GeomMesh::Vertex& corner : corners) {
        EXPECT_NEAR(corner.normal.norm(), 1, 1e-5) << geom;
        EXPECT_GT(corner.normal.dot(facet),
                  std::string(geom).find("ellipsoid") != std::string::npos ? 0.7 : 0.95)
            << geom;
      }
    }
  }
}

// Seen from its front a plane shows x to the right and y up; (0, 0) is the picture's upper left.
TEST(GeomMesh, APictureCoversAPlaneOnceOrAsOftenAsItsMaterialRepeatsIt) {
  const std::string assets =
      "<texture name='t' type='2d' builtin='flat' width='4' height='4' rgb1='1 1 1'/>"
      "<material name='once' texture='t'/><material name='often' texture='t' texrepeat='3 2'/>"
      "<material name='uniform' texture='t' texuniform='true' texrepeat='2 2'/>";
  const auto uv_at = [&](const std::string& material, float x, float y) {
    const GeomMesh mesh = mesh_of("<geom type='plane' size='2 0.5 1' material='" + material + "'/>", assets);
    for (const GeomMesh::Vertex& vertex : mesh.vertices)
      if (vertex.p.isApprox(Vector3f(x, y, 0))) return vertex.uv;
    return Vector2f(-9, -9);
  };
  EXPECT_EQ(uv_at("once", -2, 0.5f), Vector2f(0, 0));
  EXPECT_EQ(uv_at("once", 2, -0.5f), Vector2f(1, 1));
  EXPECT_EQ(uv_at("often", 2, 0.5f) - uv_at("often", -2, 0.5f), Vector2f(3, 0));
  EXPECT_EQ(uv_at("often", 2, -0.5f) - uv_at("often", 2, 0.5f), Vector2f(0, 2));
  EXPECT_EQ(uv_at("uniform", 2, -0.5f) - uv_at("uniform", -2, 0.5f), Vector2f(4, 1));  // 1 per meter
}

TEST(GeomMesh, AMeshIsDrawnWithSharpEdgesAndAHeightFieldIsRefused) {
  const GeomMesh block = mesh_of(
      "<geom type='mesh' mesh='block'/>",
      "<mesh name='block' vertex='-1 -2 -3  1 -2 -3  -1 2 -3  1 2 -3  -1 -2 3  1 -2 3  -1 2 3  1 2 3'/>");
  EXPECT_NEAR(volume(block), 48, 1e-4);
  for (const GeomMesh::Vertex& vertex : block.vertices)
    EXPECT_NEAR(vertex.normal.cwiseAbs().maxCoeff(), 1, 1e-5);
  EXPECT_THROW(
      mesh_of("<geom type='hfield' hfield='h'/>", "<hfield name='h' nrow='2' ncol='2' size='1 1 1 1'/>"),
      std::invalid_argument);
}

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
// nothing, nor does the part of the headlight that would move with the head.
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
