#include "sim/physics/arrangement.h"

#include "sim/physics/clearance.h"
#include "tests/sim/physics/test_worlds.h"

namespace sim::physics {
namespace {

using Eigen::Vector3d, testing::Each, testing::Ge, testing::Le;

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
  Model model = load_model(robot_file(), "office", models());
  arrange(*model, world, {});
  return model;
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

walking::WalkOptions ahead(double m) {
  walking::WalkOptions walk;
  walk.commands = {walking::Straight{m, 0}};
  return walk;
}

WorldOptions moved_by(double m, std::uint64_t seed = 1, double rad = 0.5) {
  WorldOptions world;
  world.moved = {seed, m, rad};
  return world;
}

/// Returns how far each named body of the room is from its place in the file, m.
std::map<std::string, double> distances(const mjModel& m, const std::string& room = "office") {
  const Model before = load_model(robot_file(), room, models());
  std::map<std::string, double> all;
  for (int body = 1; body < m.nbody; ++body)
    if (m.body_weldid[body] == 0)
      all[name_of(m, mjOBJ_BODY, body)] =
          (Vector3d(m.body_pos + 3 * body) - Vector3d(before->body_pos + 3 * body)).norm();
  return all;
}

TEST(Arrangement, MovesFurnitureThatStandsFreelyWithinTheLargestDistance) {
  const Model office = load_model(robot_file(), "office", models());
  const int moved = arrange(*office, moved_by(0.4), ahead(1));
  const std::map<std::string, double> found = distances(*office);
  EXPECT_EQ(moved, std::ranges::count_if(found, [](const auto& each) { return each.second > 0; }));
  EXPECT_GE(moved, 15);
  for (const auto& [name, m] : found) EXPECT_LE(m, 0.4) << name;
  for (const char* chair : {"chair_1", "chair_3", "chair_4", "sofa"}) EXPECT_GT(found.at(chair), 0) << chair;
  for (const char* fixed : {"window_1", "projector", "shelf_1", "partition", "rug"})
    EXPECT_EQ(found.at(fixed), 0) << fixed;
}

TEST(Arrangement, DependsOnItsSeedAlone) {
  const auto of_seed = [](std::uint64_t seed) {
    const Model office = load_model(robot_file(), "office", models());
    arrange(*office, moved_by(0.4, seed), ahead(1));
    return distances(*office);
  };
  const auto first = of_seed(1);
  EXPECT_EQ(first, of_seed(1));
  EXPECT_NE(first.at("sofa"), of_seed(2).at("sofa"));
}

// The boxes around shapes are exact for these, so that the gap between them is the true one.
TEST(Arrangement, KeepsTheCorridorOfThePathFreeAndPutsNothingIntoAnotherPiece) {
  const std::string room = R"(<worldbody>
    <geom name="floor" type="plane" size="9 9 1"/>
    <body name="beside" pos="1 1 .5"><geom type="box" size=".1 .1 .5"/></body>
    <body name="close" pos="2 -.6 .5"><geom type="box" size=".1 .1 .5"/></body>
    <body name="pair_1" pos="1 2 .5"><geom type="box" size=".1 .1 .5"/></body>
    <body name="pair_2" pos="1 2.3 .5"><geom type="box" size=".1 .1 .5"/></body>
    <body name="wall" pos="1 2.6 1.5"><geom type="plane" size="9 9 1" euler="90 0 0"/></body>
    </worldbody>)";
  const files::TemporaryFolder folder;
  files::write_text(folder / "room.xml", "<mujoco>" + room + "</mujoco>");
  std::vector<double> corridor, gaps, beyond, moves;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const Model m = load_model(robot_file(), folder / "room.xml", models());
    EXPECT_GE(arrange(*m, moved_by(1, seed, 0), ahead(3)), 2);
    const auto at = [&](const char* name) { return Vector3d(m->body_pos + 3 * part(*m, mjOBJ_BODY, name)); };
    moves.push_back((at("beside") - Vector3d(1, 1, 0.5)).norm());
    corridor.push_back(std::abs(at("beside").y()) - 0.1);
    beyond.push_back(-at("close").y() - 0.1);
    gaps.push_back((at("pair_2") - at("pair_1")).cwiseAbs().maxCoeff() - 0.2);
    EXPECT_LT(at("pair_2").y(), 2.5);
  }
  EXPECT_THAT(gaps, Each(Ge(0)));
  EXPECT_THAT(moves, Each(Le(1)));
  EXPECT_THAT(corridor, Each(Ge(0.65)));  // the path is known at its footsteps
  EXPECT_THAT(beyond, Each(Ge(0.499))) << "at least as far as before";
  EXPECT_GT(*std::ranges::max_element(moves), 0.7);
}

TEST(Arrangement, TurnsTheLamps) {
  const Model before = load_model(robot_file(), "office", models()),
              office = load_model(robot_file(), "office", models());
  WorldOptions world;
  world.light.turn_rad = std::numbers::pi / 2;
  EXPECT_EQ(arrange(*office, world, {}), 0);
  ASSERT_GT(office->nlight, 0);
  for (int i = 0; i < office->nlight; ++i) {
    const Vector3d was(before->light_dir + 3 * i), now(office->light_dir + 3 * i);
    EXPECT_LT((now - Vector3d(-was.y(), was.x(), was.z())).norm(), 1e-12);
  }
  for (const auto& [name, m] : distances(*office)) EXPECT_EQ(m, 0) << name;
}

}  // namespace
}  // namespace sim::physics
