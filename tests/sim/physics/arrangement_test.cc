#include "sim/physics/arrangement.h"

#include "tests/sim/physics/test_worlds.h"

namespace sim::physics {
namespace {

/// The poses of all geoms in W, and the directions of the lights.
struct Shown {
  explicit Shown(const mjModel& m) {
    const Data data(mj_makeData(&m));
    mj_kinematics(&m, data.get());
    mj_comPos(&m, data.get());
    mj_camlight(&m, data.get());
    for (int geom = 0; geom < m.ngeom; ++geom) geoms.push_back(geom_pose(*data, geom));
    for (int i = 0; i < m.nlight; ++i) lights.emplace_back(data->light_xdir + 3 * i);
  }
  std::vector<Eigen::Isometry3d> geoms;
  std::vector<Eigen::Vector3d> lights;
};

bool is_robot(const mjModel& m, int geom) { return m.body_weldid[m.geom_bodyid[geom]] != 0; }

Model arranged(const WorldOptions& world) {
  return arranged(load_model(robot_file(), "office", models()), world);
}

TEST(Arrangement, AStartInTheRoomMovesTheRoomAndItsLightButNotTheRobot) {
  WorldOptions world;
  const Model before = arranged(world);
  world.start = {1, -2, 0.7};
  const Model after = arranged(world);
  const Shown a(*before), b(*after);
  for (int geom = 0; geom < before->ngeom; ++geom) {
    const auto i = std::size_t(geom);
    const Eigen::Isometry3d expected =
        is_robot(*before, geom) ? a.geoms[i] : world.start.X_RW().inverse() * a.geoms[i];
    EXPECT_TRUE(b.geoms[i].isApprox(expected, 1e-9)) << name_of(*before, mjOBJ_GEOM, geom);
  }
  ASSERT_FALSE(a.lights.empty());
  for (std::size_t i = 0; i < a.lights.size(); ++i)
    EXPECT_TRUE(b.lights[i].isApprox(world.start.X_RW().linear().transpose() * a.lights[i], 1e-9));
  EXPECT_EQ(before->light_diffuse[0], after->light_diffuse[0]);
}

TEST(Arrangement, LightIsDimmedAndTurned) {
  WorldOptions world;
  const Model before = arranged(world);
  world.light = {0.25, 1};
  const Model after = arranged(world);
  const Shown a(*before), b(*after);
  EXPECT_FLOAT_EQ(after->light_diffuse[0], 0.25F * before->light_diffuse[0]);
  EXPECT_FLOAT_EQ(after->vis.headlight.ambient[1], 0.25F * before->vis.headlight.ambient[1]);
  for (std::size_t i = 0; i < a.lights.size(); ++i)
    EXPECT_TRUE(b.lights[i].isApprox(Eigen::AngleAxisd(1, Eigen::Vector3d::UnitZ()) * a.lights[i], 1e-9));
}

TEST(Arrangement, SmallFurnitureOnTheFloorIsMovedWithinTheBoundsAndTheSameForASeed) {
  WorldOptions world;
  const Model before = arranged(world);
  world.moved.seed = 3;
  const Model after = arranged(world), again = arranged(world);
  world.moved.seed = 4;
  const Model other = arranged(world);
  std::vector<std::string> moved;
  for (int body = 1; body < before->nbody; ++body) {
    const auto place = [&](const Model& model) { return Eigen::Vector3d(model->body_pos + 3 * body); };
    EXPECT_EQ(place(after), place(again));
    if (place(after) == place(before)) continue;
    moved.push_back(name_of(*before, mjOBJ_BODY, body));
    EXPECT_NE(place(after), place(other));
    // 0.3 m along x and y; a piece turns about its center, which is up to 0.1 m from its origin
    EXPECT_LT((place(after) - place(before)).norm(), 0.5) << moved.back();
    EXPECT_EQ(place(after).z(), place(before).z());
  }
  for (const char* const piece : {"chair_1", "chair_6", "cartons", "bin"})
    EXPECT_THAT(moved, testing::Contains(piece));
  for (const char* const piece : {"desk_1", "plant_1", "shelf_1", "far_wall", "detector_1", "door_1", "rug"})
    EXPECT_THAT(moved, testing::Not(testing::Contains(piece)));
}

}  // namespace
}  // namespace sim::physics
