#include "sim/physics/clearance.h"

#include <cstring>

#include "tests/sim/physics/test_worlds.h"
#include "tests/walking/walks.h"

namespace sim::physics {
namespace {

using testing::StartsWith;

/// The half-sitting robot at places of a room.
class Stander {
 public:
  explicit Stander(const std::string& room, double margin_m = 0)
      : room_(load_model(robot_file(), room, models()), margin_m) {}

  Clearance at(double x, double y) {
    walking::BodyPose pose{Eigen::Isometry3d::Identity(), half_sitting()};
    pose.X_PB.translate(Eigen::Vector3d(x, y, on_floor().robot.base_height));
    return room_.at(robot_positions(room_.model(), pose).data());
  }

  /// Returns the object that the robot touches there, or "".
  std::string object(double x, double y) {
    const Clearance clearance = at(x, y);
    return clearance.collision ? clearance.collision->object : "";
  }

 private:
  RoomClearance room_;
};

// A robot with its waist on a wall's plane stands through it, everywhere along it: the walls have no gap.
TEST(RoomClearance, WallsAreSolidAllAround) {
  using Eigen::Vector2d;
  for (const auto& [room, least, most] : {std::tuple("office", Vector2d(-4.6, -3.35), Vector2d(6.4, 3.65)),
                                          {"hall", Vector2d(-11.6, -5.35), Vector2d(13.4, 12.65)}}) {
    Stander robot(room);
    for (int axis = 0; axis < 2; ++axis)
      for (Vector2d at = least; at(axis) <= most(axis); at(axis) += 0.2)
        for (const double wall : {least(1 - axis), most(1 - axis)}) {
          at(1 - axis) = wall;
          EXPECT_NE(robot.object(at.x(), at.y()), "") << room << " " << at.transpose();
        }
  }
}

TEST(RoomClearance, NamesLinkAndObjectAndTellsWhere) {
  const Clearance clearance = Stander("hall").at(0, -4.965);  // next to the right wall, y = -5.35
  ASSERT_TRUE(clearance.collision.has_value());
  EXPECT_THAT(clearance.collision->link, StartsWith("RARM_LINK"));
  EXPECT_EQ(clearance.collision->object, "wall_right");
  EXPECT_NEAR(clearance.collision->p_W.x(), 0, 0.3);
  EXPECT_NEAR(clearance.collision->p_W.y(), -5.35, 0.05);
  EXPECT_LE(clearance.distance_m, 0);
}

// Walking sideways into a flat wall, in steps of 1 mm.
TEST(RoomClearance, AMarginIsADistance) {
  const auto first = [](double margin_m) {
    Stander robot("hall", margin_m);
    double y = -4.7;
    while (!robot.at(0, y).collision) y -= 0.001;
    return y;
  };
  EXPECT_NEAR(first(0.05) - first(0), 0.05, 0.002);
}

// World's sparse checks rely on this.
TEST(RoomClearance, TheDistanceNeverExceedsThePathToTheFirstTouch) {
  Stander robot("office");
  double touched_x = 0;
  while (!robot.at(touched_x, 0).collision) touched_x += 0.01;
  EXPECT_GT(touched_x, 2);
  for (double x = 0; x < touched_x; x += 0.05) EXPECT_LE(robot.at(x, 0).distance_m, touched_x - x) << x;
}

TEST(RoomClearance, ShapesWithoutContactsAreNotSolid) {
  const TemporaryFolder folder;
  for (const char* bits : {"", "contype='0' conaffinity='0'"}) {
    files::write_text(folder / "room.xml",
                      fmt::format("<mujoco><worldbody><body><geom name='floor' type='plane' size='5 5 1'/>"
                                  "<geom name='sky' type='box' size='4 4 4' {}/></body></worldbody></mujoco>",
                                  bits));
    EXPECT_EQ(Stander((folder / "room.xml").string()).object(0, 0), *bits ? "" : "sky");
  }
}

TEST(RoomClearance, ARoomCanHaveMoreBodiesWithPlanesThanTheRobotHasBodies) {
  const TemporaryFolder folder;
  std::string room = "<mujoco><worldbody><geom name='floor' type='plane' size='5 5 1'/>";
  for (int i = 0; i < 80; ++i)
    room += fmt::format(
        "<body name='picture_{}' pos='1 {} 0.8'><geom type='plane' zaxis='-1 0 0' size='.1 .1 1'/></body>", i,
        0.1 * i - 4);
  files::write_text(folder / "room.xml", room + "</worldbody></mujoco>");
  EXPECT_THAT(Stander((folder / "room.xml").string()).object(1, 0), StartsWith("picture_"));
}

// A field's front face is vertical. Three columns and rows: 1 m high up to the middle, 0 at the back.
TEST(RoomClearance, AHeightFieldIsAsSolidAsABoxWithItsFront) {
  const TemporaryFolder folder;
  std::string field(44, '\0');  // numbers of rows and columns, then the heights
  const std::array<std::int32_t, 2> counts{3, 3};
  const std::array<float, 9> heights{1, 1, 0, 1, 1, 0, 1, 1, 0};
  std::memcpy(field.data(), counts.data(), 8);
  std::memcpy(field.data() + 8, heights.data(), 36);
  files::write_text(folder / "field.bin", field);
  const auto touched_at = [&](const char* hill) {
    files::write_text(
        folder / "room.xml",
        fmt::format(
            "<mujoco><asset><hfield name='f' file='field.bin' size='1 2 1 0.1'/></asset><worldbody>"
            "<geom name='floor' type='plane' size='9 9 1'/><geom name='hill' {}/></worldbody></mujoco>",
            hill));
    Stander robot((folder / "room.xml").string());
    double x = 0;
    while (x < 3 && !robot.at(x, 0).collision) x += 0.001;
    EXPECT_EQ(robot.object(x, 0), "hill");
    EXPECT_NEAR(robot.at(0, 0).distance_m, x, 0.3) << "spheres around the robot's shapes";
    const auto plan =
        walking::PatternGenerator(on_floor().robot, walking::walk_of({walking::Straight{3, 0}}));
    const auto found =
        first_collision(plan, load_model(robot_file(), (folder / "room.xml").string(), models()));
    EXPECT_EQ(found.value().object, "hill");
    return x;
  };
  const double x = touched_at("type='box' size='0.5 2 0.5' pos='2.5 0 0.5'");
  EXPECT_NEAR(touched_at("type='hfield' hfield='f' pos='3 0 0'"), x, 0.0015);
  EXPECT_NEAR(x, 2, 0.4);
}

TEST(BoxAround, EnclosesEachKindOfShape) {
  using Eigen::Vector3d;
  const struct {
    const char* geom;
    Vector3d low, high;
  } shapes[] = {{"type='plane' size='1 2 1'", {-2, -1, 0}, {2, 1, 0}},
                {"type='box' size='1 2 3'", {-2, -1, -3}, {2, 1, 3}},
                {"type='ellipsoid' size='1 2 3'", {-2, -1, -3}, {2, 1, 3}},
                {"type='sphere' size='2'", {-2, -2, -2}, {2, 2, 2}},
                {"type='cylinder' size='1 3'", {-1, -1, -3}, {1, 1, 3}},
                {"type='capsule' size='1 3'", {-1, -1, -4}, {1, 1, 4}},
                {"type='mesh' mesh='m'", {-2, -1, -3}, {2, 1, 3}},
                {"type='hfield' hfield='f'", {-2, -1, -0.5}, {2, 1, 3}}};
  for (const auto& shape : shapes) {
    const Model model = small_model(fmt::format(
        "<asset><hfield name='f' nrow='2' ncol='2' size='1 2 3 0.5'/><mesh name='m' vertex='-1 -2 -3 "
        "1 -2 -3 -1 2 -3 1 2 -3 -1 -2 3 1 -2 3 -1 2 3 1 2 3'/></asset><worldbody>"
        "<geom {} pos='10 20 30' euler='0 0 90'/></worldbody>",
        shape.geom));
    const Data data(mj_makeData(model.get()));
    mj_kinematics(model.get(), data.get());
    const Eigen::AlignedBox3d box = box_around(*model, *data, 0);
    const Vector3d at(10, 20, 30);
    EXPECT_TRUE(box.min().isApprox(at + shape.low, 1e-6)) << shape.geom << " " << box.min().transpose();
    EXPECT_TRUE(box.max().isApprox(at + shape.high, 1e-6)) << shape.geom << " " << box.max().transpose();
  }
}

}  // namespace
}  // namespace sim::physics
