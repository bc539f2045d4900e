#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <set>

#include "sim/camera/head_camera.h"
#include "sim/camera/shapes.h"
#include "sim/room/paint.h"
#include "sim/score/types.h"
#include "tests/sim/physics/test_worlds.h"

namespace sim::camera {
using namespace physics;
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

// Half the extents of a surface along W's axes.
Vector3d half_box(const score::Surface& surface) {
  Vector3d half = surface.size;
  using enum score::Surface::Kind;
  if (surface.kind == cylinder || surface.kind == capsule)
    half = {half.x(), half.x(), half.y() + (surface.kind == capsule ? half.x() : 0)};
  return surface.X_WS.linear().cwiseAbs() * half;
}

Model robot_in(const std::string& room) { return load_model("hrp2", room, models()); }

// A furnished room: its middle and size, and how much is free about the circles walked, m.
struct Room {
  std::string name;
  Vector2d middle;
  Vector3d size;
  double free;
};
const Room kOffice{"office", {0.9, 0.15}, {11, 7, 3}, 2}, kHall{"hall", {0.9, 3.65}, {25, 18, 3}, 4};

bool is_shell(const score::Surface& surface) {
  return surface.kind == score::Surface::Kind::plane && surface.size.prod() == 0 &&
         surface.size.maxCoeff() > 3;
}

}  // namespace

// The hall of 11 x 25 m and the open office of 7 x 25 m beside it are one space.
TEST(Rooms, HaveTheirSizeEverythingStandsInsideAndMetersAroundTheWalkAreFree) {
  const Vector2d walked(0.9, 0.15);  // middle of the circles
  for (const Room& room : {kOffice, kHall}) {
    const Eigen::AlignedBox2d floor(room.middle - room.size.head<2>() / 2 - Vector2d(1e-3, 1e-3),
                                    room.middle + room.size.head<2>() / 2 + Vector2d(1e-3, 1e-3));
    Eigen::AlignedBox3d shell;
    for (const score::Surface& surface : room_surfaces(*robot_in(room.name))) {
      const Vector3d center = surface.X_WS.translation(), half = half_box(surface);
      const Eigen::AlignedBox3d box(center - half, center + half);
      if (is_shell(surface)) shell.extend(box);
      EXPECT_TRUE(floor.contains(box.min().head<2>()) && floor.contains(box.max().head<2>())) << room.name;
      EXPECT_LT(box.max().z(), 3.0 + 1e-9);
      // What hangs above the robot or is part of the floor is not in its way.
      if (is_shell(surface) || box.min().z() > 2 || box.max().z() < 0.002) continue;
      const Vector2d away = ((center.head<2>() - walked).cwiseAbs() - half.head<2>()).cwiseMax(0);
      EXPECT_GT(away.norm(), room.free) << room.name << " " << center.transpose();
    }
    EXPECT_LT((shell.sizes() - room.size).norm(), 1e-9) << room.name;
    EXPECT_LT((shell.center().head<2>() - room.middle).norm(), 1e-9) << room.name;
    EXPECT_NEAR(shell.min().z(), 0, 1e-12);
  }
}

TEST(Rooms, EachTextureHasAPainterThatDependsOnNameAndSeedOnly) {
  for (const Room& room : {kOffice, kHall}) {
    const Model model = robot_in(room.name);
    EXPECT_GT(model->ntex, 30);
    for (int id = 0; id < model->ntex; ++id) {
      const std::string name = mj_id2name(model.get(), mjOBJ_TEXTURE, id);
      EXPECT_FALSE(room::paint_texture(name, 1).empty()) << name;
    }
  }
  const cv::Mat3b books = room::paint_texture("books_2", 1);
  EXPECT_EQ(cv::norm(books, room::paint_texture("books_2", 1), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(books, room::paint_texture("books_2", 2), cv::NORM_INF), 100);
  EXPECT_GT(cv::norm(books, room::paint_texture("books_3", 1), cv::NORM_INF), 100);
  EXPECT_TRUE(room::paint_texture("no such thing_1", 1).empty());
}

// The highest plane below the circles walked: the floor, or a sharper piece of it just above.
TEST(Rooms, FloorIsPaintedToTwoMillimetersPerTexelWhereTheRobotWalks) {
  for (const Room& room : {kOffice, kHall}) {
    const Model model = robot_in(room.name);
    double height = -1, texel_m = 0;
    for (int geom = 0; geom < model->ngeom; ++geom) {
      const mjtNum *place = model->geom_pos + 3 * geom, *half = model->geom_size + 3 * geom;
      const bool below = model->geom_type[geom] == mjGEOM_PLANE && model->geom_bodyid[geom] == 0 &&
                         std::hypot(place[0] - 0.9, place[1] - 0.15) < 0.01 && place[2] < 0.01;
      if (!below || place[2] < height) continue;
      const std::string paint = mj_id2name(model.get(), mjOBJ_MATERIAL, model->geom_matid[geom]);
      height = place[2], texel_m = 2 * half[1] / room::paint_texture(paint, 1).rows;
    }
    EXPECT_NEAR(texel_m, 0.002, 1e-6) << room.name;
  }
}

// MonoSLAM's corners: the smaller eigenvalue of the summed gradient matrix of an 11x11 patch is at least
// 20000. OpenCV scales Sobel's gradients (8 times a central difference of one pixel) by 1 / (4 * 11 * 255).
TEST(Office, OffersCornersAllOverTheImageAtEveryHeading) {
  constexpr double kThreshold = 20000 * 4.0 / ((11 * 255.0) * (11 * 255.0));
  HeadCamera camera(robot_in("office"), CameraOptions{});
  const Data plant = data_at_rest(camera.model());
  for (int step = 0; step < 16; ++step) {
    stand_on_circle(*plant, step * 2 * CV_PI / 16);
    const cv::Mat1b image = camera.render(*plant);
    cv::Mat1f strength;
    cv::cornerMinEigenVal(image, strength, 11, 3);
    std::vector<cv::Point2f> corners;
    cv::goodFeaturesToTrack(image, corners, 0, 1e-6, 10, strength > kThreshold, 11);
    std::set<int> twelfths;
    for (const cv::Point2f& corner : corners) twelfths.insert(int(corner.x) / 80 + 4 * (int(corner.y) / 80));
    EXPECT_GE(corners.size(), 30u) << step;  // two and a half times what the filter keeps in view
    EXPECT_GE(twelfths.size(), 7u) << step;
  }
}

// The score's own ray caster, independent of MuJoCo, on the result of room_surfaces.
TEST(RoomSurfaces, RaysMeetThemWhereMuJoCosDo) {
  for (const Room& room_of : {kOffice, kHall}) {
    const Model model = robot_in(room_of.name);
    const Data data(mj_makeData(model.get()));
    mj_forward(model.get(), data.get());
    const std::vector<score::Surface> surfaces = room_surfaces(*model);
    cv::RNG random(5);
    constexpr mjtByte room[mjNGROUP] = {1, 0, 0, 0, 0, 0};
    for (int i = 0; i < 3000; ++i) {
      const Vector3d from{random.uniform(0.0, 1.8), random.uniform(-0.6, 1.1), random.uniform(1.2, 1.5)};
      const Vector3d along =
          Vector3d{random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-0.7, 0.7)}
              .normalized();
      int geom;
      const double expected = mj_ray(model.get(), data.get(), from.data(), along.data(), room, 1, -1, &geom);
      const std::optional<double> found = score::first_hit(surfaces, from, along);
      ASSERT_TRUE(found.has_value());
      ASSERT_NEAR(*found, expected, 1e-6)
          << "geom " << geom;  // rounding of distances of some meters, grazing included
    }
  }
}

TEST(RoomSurfaces, AreGivenByTheirHalfExtentsWithoutTheRobot) {
  const char* const room =
      "<worldbody><geom type='capsule' size='0.1 0.4' pos='1 2 3'/><geom type='plane' size='2 3 1'/>"
      "<body pos='0 0 1'><freejoint/><geom type='sphere' size='0.2'/></body></worldbody>";
  const std::vector<score::Surface> surfaces = room_surfaces(*SmallModel(room).load());
  ASSERT_EQ(surfaces.size(), 2u);
  EXPECT_EQ(surfaces[0].kind, score::Surface::Kind::capsule);
  EXPECT_EQ(surfaces[0].size, Vector3d(0.1, 0.4, 0));
  EXPECT_EQ(surfaces[0].X_WS.translation(), Vector3d(1, 2, 3));
  EXPECT_EQ(surfaces[1].kind, score::Surface::Kind::plane);
  EXPECT_EQ(surfaces[1].size, Vector3d(2, 3, 0));
}

}  // namespace sim::camera
