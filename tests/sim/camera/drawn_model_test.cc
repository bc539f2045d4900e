#include "sim/camera/drawn_model.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <fstream>
#include <random>
#include <set>

#include "sim/camera/shapes.h"
#include "sim/camera/urdf.h"
#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/physics/test_worlds.h"

namespace sim::camera {
using namespace physics;
namespace {

const Eigen::Isometry3d kSomewhere =
    Eigen::Translation3d(1, 2, 0.65) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ());

Eigen::Isometry3d pose(const std::vector<float>& poses, std::size_t body) {
  const float* const x = poses.data() + 7 * body;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Quaterniond(x[6], x[3], x[4], x[5]).toRotationMatrix();
  X.translation() = Eigen::Vector3d(x[0], x[1], x[2]);
  return X;
}

std::size_t index_of(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

// The physics knows fewer shapes than the drawing, but the same bodies.
TEST(DrawnModel, BodiesOfThePlantAndOfTheDrawnRobotAreAtTheSamePlaces) {
  PosedRobot robot("hrp2", "office", models());
  const World world = standing({}, kSomewhere);
  const std::vector<std::string>& names = robot.drawn().bodies;
  const std::vector<float> plant = BodyPoses(*world.model(), names).of(*world.data()),
                           drawn = robot.poses({world.X_WB(), half_sitting()});
  ASSERT_EQ(plant.size(), 7 * names.size());
  ASSERT_EQ(drawn.size(), plant.size());
  EXPECT_GE(names.size(), 29u);
  for (std::size_t body = 0; body < names.size(); ++body)  // float, and bushes that carry no weight yet
    EXPECT_TRUE(pose(plant, body).isApprox(pose(drawn, body), 1e-5)) << names[body];
  const std::size_t waist = index_of(names, "BODY");
  ASSERT_LT(waist, names.size());
  EXPECT_TRUE(pose(drawn, waist).isApprox(world.X_WB(), 1e-6));
}

TEST(DrawnModel, EveryDrawnShapeIsInAPiece) {
  const PosedRobot robot("hrp2", "office", models());
  std::size_t vertices = 0;
  std::set<int> bodies;
  for (const DrawnPiece& piece : robot.drawn().pieces) {
    const std::size_t count = piece.positions.size() / 3;
    EXPECT_EQ(piece.normals.size(), 3 * count);
    EXPECT_EQ(piece.colours.size(), 3 * count);
    EXPECT_EQ(piece.uv.size(), piece.picture < 0 ? 0 : 2 * count);
    EXPECT_EQ(piece.indices.size() % 3, 0u);
    EXPECT_LT(*std::max_element(piece.indices.begin(), piece.indices.end()), count);
    vertices += count;
    bodies.insert(piece.body);
  }
  EXPECT_GT(vertices, 10'000u);
  EXPECT_EQ(bodies.size(), robot.drawn().bodies.size() + 1) << "each body, and the room";
}

TEST(DrawnModel, TheRoomIsAroundTheRobot) {
  const PosedRobot robot("hrp2", "office", models());
  Eigen::AlignedBox3f room;
  for (const DrawnPiece& piece : robot.drawn().pieces)
    for (std::size_t i = 0; piece.body < 0 && i < piece.positions.size(); i += 3)
      room.extend(Eigen::Vector3f(piece.positions[i], piece.positions[i + 1], piece.positions[i + 2]));
  EXPECT_NEAR(room.min().z(), 0, 0.05);  // the floor
  EXPECT_GT(room.max().z(), 2.2f);       // the ceiling
  EXPECT_GT(room.sizes().head<2>().minCoeff(), 4.5f);
}

TEST(DrawnModel, PicturesArePaintedFromTheSeed) {
  const PosedRobot robot("hrp2", "office", models());
  const auto pictures = drawn_pictures(robot.model(), robot.drawn(), 1, 64),
             again = drawn_pictures(robot.model(), robot.drawn(), 1, 64),
             others = drawn_pictures(robot.model(), robot.drawn(), 2, 64);
  ASSERT_EQ(pictures.size(), robot.drawn().pictures.size());
  EXPECT_GT(pictures.size(), 10u);
  double differ = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    EXPECT_LE(std::max(pictures[i].cols, pictures[i].rows), 64);
    EXPECT_TRUE(std::has_single_bit(unsigned(pictures[i].cols)) &&
                std::has_single_bit(unsigned(pictures[i].rows)));
    EXPECT_EQ(cv::norm(pictures[i], again[i]), 0);
    differ += cv::norm(pictures[i], others[i]);
  }
  EXPECT_GT(differ, 0);
}

TEST(DrawnModel, ABodyThatTheModelDoesNotHaveIsRefused) {
  const World world = standing();
  EXPECT_THROW(BodyPoses(*world.model(), {"TAIL"}), std::invalid_argument);
}

}  // namespace

using namespace physics;
namespace {

// An independent reader of the format and the simulator agree on the place of every link.
TEST(Urdf, LinksAreWhereTheBodiesOfTheModelAre) {
  PosedRobot robot("hrp2", "office", models());
  const files::TemporaryFolder folder;
  std::ofstream(folder / "robot.urdf") << urdf(robot.model());
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angle(-1, 1);
  for (int trial = 0; trial < 3; ++trial) {
    walking::JointVector q;
    std::ofstream angles(folder / "angles");
    const std::vector<std::string> names = joint_names();
    for (int joint = 0; joint < walking::kJoints; ++joint) {
      q[joint] = trial == 0 ? 0 : angle(random);
      angles << names[static_cast<std::size_t>(joint)] << ' ' << fmt::format("{}", q[joint]) << '\n';
    }
    angles.close();
    const std::string command = fmt::format(
        "/usr/bin/python3 '{}/tests/interop/read_urdf.py' '{}' '{}' > '{}'", GAITSLAM_SOURCE_DIR,
        (folder / "robot.urdf").string(), (folder / "angles").string(), (folder / "read").string());
    ASSERT_EQ(std::system(command.c_str()), 0);
    const std::vector<float> expected = robot.poses({Eigen::Isometry3d::Identity(), q});
    std::ifstream read(folder / "read");
    std::size_t links = 0, seen = 0;
    for (std::string name; read >> name; ++links) {
      Eigen::Matrix<double, 3, 4> X;
      for (int i = 0; i < 12; ++i) read >> X(i / 4, i % 4);
      const auto& bodies = robot.drawn().bodies;
      const auto found = std::find(bodies.begin(), bodies.end(), name);
      if (found == bodies.end()) continue;
      ++seen;
      const float* const x = &expected[7 * static_cast<std::size_t>(found - bodies.begin())];
      EXPECT_TRUE(X.col(3).isApprox(Eigen::Vector3d(x[0], x[1], x[2]), 1e-5)) << name;
      EXPECT_TRUE(
          X.leftCols<3>().isApprox(Eigen::Quaterniond(x[6], x[3], x[4], x[5]).toRotationMatrix(), 1e-5))
          << name;
    }
    EXPECT_GE(links, 31u);
    EXPECT_GE(seen, 29u);
  }
}

TEST(Urdf, EveryDrawnShapeIsInIt) {
  const PosedRobot robot("hrp2", "office", models());
  const std::string text = urdf(robot.model());
  std::size_t expected = 0, found = 0;
  for (int geom = 0; geom < robot.model().ngeom; ++geom)
    if (robot.model().body_weldid[robot.model().geom_bodyid[geom]] != 0 && is_drawn(robot.model(), geom))
      expected += robot.model().geom_type[geom] == mjGEOM_CAPSULE ? 3 : 1;
  for (std::size_t at = 0; (at = text.find("<visual>", at)) != text.npos; ++at) ++found;
  EXPECT_GT(expected, 60u);
  EXPECT_EQ(found, expected);
}

TEST(Urdf, AModelWithoutARobotIsRefused) {
  const SmallModel room("<worldbody><geom name=\"floor\" type=\"plane\" size=\"1 1 1\"/></worldbody>");
  EXPECT_THROW(urdf(*room.load()), std::invalid_argument);
}

}  // namespace

}  // namespace sim::camera
