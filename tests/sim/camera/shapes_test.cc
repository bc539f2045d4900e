#include "sim/camera/shapes.h"

#include <opencv2/imgproc.hpp>

#include "sim/camera/scene.h"
#include "tests/sim/physics/test_worlds.h"

namespace sim::camera {
using namespace physics;
namespace {

using Eigen::Vector2f, Eigen::Vector3f;

GeomMesh mesh_of(const std::string& geom, const std::string& assets = "") {
  return geom_mesh(*small_model("<asset>" + assets + "</asset><worldbody>" + geom + "</worldbody>"), 0);
}

const std::string kCorner = "<mesh name='corner' vertex='0 0 0 1 0 0 0 1 0 0 0 1'/>";

TEST(RoomSurfaces, AMeshHasOneSurfacePerFace) {
  const auto surfaces =
      room_surfaces(*small_model("<asset>" + kCorner +
                                 "</asset><worldbody><geom type='mesh' mesh='corner' pos='0 0 2'/>"
                                 "</worldbody>"));
  ASSERT_EQ(surfaces.size(), 4u);
  const auto up = Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(score::first_hit(surfaces, {0.2, 0.3, 0}, up).value(), 2, 1e-6);
  EXPECT_NEAR(score::first_hit(surfaces, {0.2, 0.3, 5}, -up).value(), 2.5, 1e-6) << "x + y + z = 1";
  EXPECT_FALSE(score::first_hit(surfaces, {0.6, 0.6, 0}, up));
}

TEST(Textures, ATextureWithItsOwnPictureIsNotPainted) {
  const auto picture = [](const std::string& builtin) {
    const Model model =
        small_model("<asset><texture type='2d' width='4' height='4' rgb2='1 1 1' name='books_7' builtin='" +
                    builtin + "'/></asset>");
    return texture_picture(*model, *data_at_rest(*model), 0, 1);
  };
  EXPECT_GT(picture("flat").cols, 100);
  EXPECT_EQ(picture("checker").cols, 4);
}

// Round shapes are at most 20-sided prisms: a circle keeps 20/(2 pi) sin(2 pi/20) = 0.984 of its area, and a
// sphere's stacks of 30 degrees cost another 8 %. A facet of 18 by 30 degrees leans from the normals at its
// corners by up to half its diagonal, 17 degrees; an ellipsoid of 1 : 3 stretches that.
TEST(GeomMesh, EnclosesTheVolumeOfItsShapeWithTheNormalsOfItsTriangles) {
  constexpr double pi = std::numbers::pi;
  const struct {
    const char* geom;
    double volume, least_part, least_cosine;
  } shapes[] = {{"<geom type='plane' size='1 2 1'/>", 0, 0, 0.999},
                {"<geom type='box' size='0.1 0.2 0.3'/>", 8 * 0.1 * 0.2 * 0.3, 0.9999, 0.999},
                {"<geom type='cylinder' size='0.2 0.5'/>", pi * 0.04 * 1, 0.98, 0.95},
                {"<geom type='sphere' size='0.3'/>", 4 * pi / 3 * 0.027, 0.9, 0.95},
                {"<geom type='ellipsoid' size='0.1 0.2 0.3'/>", 4 * pi / 3 * 0.006, 0.9, 0.7},
                {"<geom type='capsule' size='0.1 0.4'/>", pi * 0.01 * 0.8 + 4 * pi / 3 * 0.001, 0.95, 0.95},
                {"<geom type='mesh' mesh='corner'/>", 1.0 / 6, 0.9999, 0.999}};
  for (const auto& shape : shapes) {
    const GeomMesh mesh = mesh_of(shape.geom, kCorner);
    double volume = 0;  // by the divergence theorem; negative if triangles face inwards
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      const auto corner = [&](std::size_t k) { return mesh.vertices[mesh.indices[i + k]]; };
      const Vector3f a = corner(0).p, b = corner(1).p, c = corner(2).p;
      volume += double(a.dot(b.cross(c))) / 6;
      for (const std::size_t k : {0, 1, 2}) {
        EXPECT_NEAR(corner(k).normal.norm(), 1, 1e-5) << shape.geom;
        EXPECT_GT(corner(k).normal.dot((b - a).cross(c - a).normalized()), shape.least_cosine) << shape.geom;
      }
    }
    EXPECT_GE(volume, shape.least_part * shape.volume) << shape.geom;
    EXPECT_LE(volume, 1.0001 * shape.volume) << shape.geom;
  }
}

// Seen from its front a plane shows x to the right and y up; (0, 0) is the picture's upper left.
TEST(GeomMesh, APictureCoversAPlaneOnceOrAsOftenAsItsMaterialRepeatsIt) {
  const std::string assets =
      "<texture name='t' type='2d' builtin='flat' width='4' height='4' rgb1='1 1 1'/>"
      "<material name='once' texture='t'/><material name='often' texture='t' texrepeat='3 2'/>";
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
}

TEST(RoomSurfaces, AHeightFieldLiesWhereMuJoCosRaysHitIt) {
  const physics::Model model = physics::load_model(physics::robot_file(), "yard", physics::models());
  const physics::Data data = data_at_rest(*model);
  const int ground = physics::part(*model, mjOBJ_GEOM, "ground");
  const std::vector<score::Surface> all = room_surfaces(*model);
  double lowest = 1, highest = -1;
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d from(-1 + 0.021 * k, 1.5 * std::sin(k), 0.5), down(0, 0, -1);
    const double distance = mj_rayHfield(model.get(), data.get(), ground, from.data(), down.data());
    EXPECT_NEAR(score::first_hit(all, from, down).value(), distance, 1e-6) << k;
    lowest = std::min(lowest, 0.5 - distance), highest = std::max(highest, 0.5 - distance);
  }
  EXPECT_GT(highest - lowest, 0.02);
  EXPECT_GT(highest, 0);
}

const std::string kHeadlight =
    "<visual><headlight ambient='0.2 0.2 0.2' diffuse='0.9 0.9 0.9' specular='1 1 1'/></visual>";

Lamps lamps(const std::string& lights) {
  return Lamps(*small_model(kHeadlight + "<worldbody>" + lights + "</worldbody>"));
}

// Computed by hand: 0.2 of the headlight, 0.1 ambient, 0.5 cos(60 degrees) of the lamp. The lamp from below
// adds nothing, and neither does the part of the headlight that would move with the head.
TEST(Lamps, ASurfaceIsLitByTheLampsInFrontOfIt) {
  const Lamps two = lamps(
      "<light directional='true' dir='-0.8660254 0 -0.5' ambient='0.1 0.1 0.1' diffuse='0.5 0.4 0.3'/>"
      "<light directional='true' dir='0 0 1' diffuse='1 1 1'/>");
  const Paint paint{{1, 0.5f, 0.1f}, 0.1f};
  EXPECT_TRUE(two.lit(paint, Vector3f::UnitZ(), 1).isApprox(Vector3f(0.65f, 0.3f, 0.055f), 1e-5f));
  EXPECT_TRUE(two.lit(paint, Vector3f::UnitZ(), 0.5f).isApprox(Vector3f(0.375f, 0.175f, 0.0325f), 1e-5f));
  EXPECT_EQ(two.lit({{1, 1, 1}, 2}, Vector3f::UnitZ(), 1), Vector3f(1, 1, 1));
}

TEST(Paint, ComesFromTheMaterialUnlessTheGeomHasItsOwnColor) {
  const Model model = small_model(
      "<asset><material name='red' rgba='1 0 0 1' emission='0.5'/></asset><worldbody>"
      "<geom size='1' material='red'/><geom size='1' material='red' rgba='0 1 0 0.5'/></worldbody>");
  EXPECT_EQ(paint_of(*model, 0).rgb, Vector3f(1, 0, 0));
  EXPECT_EQ(paint_of(*model, 0).emission, 0.5f);
  EXPECT_EQ(paint_of(*model, 1).rgb, Vector3f(0, 1, 0));
  EXPECT_EQ(paint_of(*model, 1).alpha, 0.5f);
}

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

TEST(Scene, HidesFarSurfacesBacksAndTransparentThingsAndBlackensMaskedParts) {
  const Model model = small_model(kSheets);
  Pinhole masked = kView;
  masked.unsampled = {{0, 0, 40, 30}, {200, 100, 40, 80}};
  Scene scene(*model, {masked}, 1, Channels::gray);
  const cv::Mat1b picture = scene.draw(*data_at_rest(*model), looking(0));
  for (int row = 0; row < picture.rows; ++row)
    for (int column = 0; column < picture.cols; ++column) {
      const double across = std::abs(column - 119.5), down = std::abs(row - 89.5);  // edges: 0.5 / 2 * 120 px
      const bool is_masked = std::ranges::any_of(masked.unsampled, [&](const cv::Rect& area) {
        return area.contains({column, row});
      });
      ASSERT_EQ(picture(row, column), is_masked                  ? 0
                                      : across < 30 && down < 30 ? 204
                                                                 : 102)
          << row << " " << column;
    }
}

// Gray 0.4 at 3 m, a pane of 0.8 and alpha 0.25 at 2 m, and one of 1.0 and alpha 0.5 at 1 m that covers the
// left half. In the model, the nearer pane comes first.
TEST(Scene, BlendsGlassOverWhatIsBehindItFromFarToNearAndDepthPassesThrough) {
  const Model model = small_model(
      "<asset><material name='half' rgba='1 1 1 0.5'/></asset>"
      "<visual><headlight ambient='1 1 1' diffuse='0 0 0'/></visual><worldbody>"
      "<geom type='plane' size='9 9 1' pos='1.9 9.15 1.3' xyaxes='0 -1 0 0 0 1' material='half'/>"
      "<geom type='plane' size='9 9 1' pos='2.9 0.15 1.3' xyaxes='0 -1 0 0 0 1' rgba='0.8 0.8 0.8 0.25'/>"
      "<geom type='plane' size='9 9 1' pos='3.9 0.15 1.3' xyaxes='0 -1 0 0 0 1' rgba='0.4 0.4 0.4 1'/>"
      "</worldbody>");
  Scene scene(*model, {kView}, 1, Channels::gray);
  const cv::Mat1b picture = scene.draw(*data_at_rest(*model), looking(0));
  const double one = 0.25 * 0.8 + 0.75 * 0.4, both = 0.5 * 1 + 0.5 * one;
  EXPECT_NEAR(picture(90, 200), 255 * one, 1);
  EXPECT_NEAR(picture(90, 40), 255 * both, 1);
  const cv::Mat1f depth = scene.read_depth().inverse_depth();
  EXPECT_NEAR(depth(90, 200), 1.0 / 3, 1e-4);
  EXPECT_NEAR(depth(90, 40), 1.0 / 3, 1e-4);
  EXPECT_EQ(room_surfaces(*model).size(), 1u);
}

// The color path rounds twice and the gray path once; each has eight bits for the fraction of a texel.
TEST(Scene, GrayIsTheBrightnessOfTheColorsWithinTwoLevels) {
  const Model model = load_model(robot_file(), "office", models());
  const Data data = data_at_rest(*model);
  Scene gray(*model, {kView}, 1, Channels::gray), colored(*model, {kView}, 1, Channels::rgb);
  for (const double yaw : {0.0, 1.5, 3.0, 4.5})
    for (const float light : {1.0f, 0.3f}) {
      cv::Mat expected;
      cv::cvtColor(colored.draw(*data, looking(yaw), light), expected, cv::COLOR_RGB2GRAY);
      const cv::Mat found = gray.draw(*data, looking(yaw), light);
      EXPECT_LE(cv::norm(found, expected, cv::NORM_INF), 2) << yaw << " " << light;
      cv::Scalar mean, contrast;
      cv::meanStdDev(found, mean, contrast);
      EXPECT_GT(contrast[0], light * 10) << "the comparison is not empty";
    }
}

}  // namespace
}  // namespace sim::camera
