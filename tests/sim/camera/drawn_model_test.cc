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
#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/physics/test_worlds.h"

namespace sim::camera {
using namespace physics;
namespace {

const Eigen::Isometry3d kSomewhere =
    Eigen::Translation3d(1, 2, 0.65) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ());

class DrawnRobot : public testing::Test {
 protected:
  /// Pose of a named body in a list of poses.
  Eigen::Isometry3d pose(const std::vector<float>& poses, const std::string& body) const {
    const auto& names = robot_.bodies();
    const float* const x = &poses.at(7 * std::size_t(std::ranges::find(names, body) - names.begin()));
    return Eigen::Translation3d(x[0], x[1], x[2]) *
           Eigen::Isometry3d(Eigen::Quaterniond(x[6], x[3], x[4], x[5]).normalized());
  }

  PosedRobot robot_{"hrp2", "office", models()};
};

// The physics knows fewer shapes than the drawing, but the same bodies.
TEST_F(DrawnRobot, HasItsBodiesWhereThePlantHasThem) {
  const World world = standing({}, kSomewhere);
  const std::vector<std::string>& names = robot_.bodies();
  const std::vector<float> plant = body_poses(*world.model(), *world.data(), names),
                           drawn = robot_.poses({world.X_WB(), half_sitting()});
  EXPECT_GE(names.size(), 29u);
  for (const std::string& body : names)  // float, and bushes that carry no weight yet
    EXPECT_TRUE(pose(plant, body).isApprox(pose(drawn, body), 1e-5)) << body;
  EXPECT_TRUE(pose(drawn, "BODY").isApprox(world.X_WB(), 1e-6));
  EXPECT_THROW(body_poses(*world.model(), *world.data(), {"TAIL"}), std::invalid_argument);
}

TEST_F(DrawnRobot, IsInsideItsRoomAndAllVerticesAreComplete) {
  std::size_t vertices = 0;
  std::set<int> bodies;
  Eigen::AlignedBox3f room;
  for (const DrawnPiece& piece : robot_.pieces()) {
    const std::size_t count = piece.positions.size() / 3;
    EXPECT_EQ(piece.normals.size(), 3 * count);
    EXPECT_EQ(piece.colours.size(), 3 * count);
    EXPECT_EQ(piece.uv.size(), piece.picture < 0 ? 0 : 2 * count);
    EXPECT_EQ(piece.indices.size() % 3, 0u);
    EXPECT_LT(*std::max_element(piece.indices.begin(), piece.indices.end()), count);
    vertices += count;
    bodies.insert(piece.body);
    for (std::size_t i = 0; piece.body < 0 && i < piece.positions.size(); i += 3)
      room.extend(Eigen::Map<const Eigen::Vector3f>(&piece.positions[i]));
  }
  EXPECT_GT(vertices, 10'000u);
  EXPECT_EQ(bodies.size(), robot_.bodies().size() + 1) << "each body, and the room";
  EXPECT_NEAR(room.min().z(), 0, 0.05);  // the floor
  EXPECT_GT(room.max().z(), 2.2f);       // the ceiling
  EXPECT_GT(room.sizes().head<2>().minCoeff(), 4.5f);
}

TEST_F(DrawnRobot, HasPicturesThatArePaintedFromTheSeed) {
  const auto painted = [&](int seed) { return robot_.pictures(seed, 64); };
  const auto pictures = painted(1), again = painted(1), others = painted(2);
  EXPECT_GT(pictures.size(), 10u);
  double differ = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    for (const int side : {pictures[i].cols, pictures[i].rows})
      EXPECT_TRUE(side <= 64 && std::has_single_bit(unsigned(side))) << side;
    EXPECT_EQ(cv::norm(pictures[i], again[i]), 0);
    differ += cv::norm(pictures[i], others[i]);
  }
  EXPECT_GT(differ, 0);
}

// An independent reader of the format and the simulator agree on the place of every link.
TEST_F(DrawnRobot, AsUrdfHasItsLinksWhereTheBodiesOfTheModelAre) {
  const files::TemporaryFolder folder;
  std::ofstream(folder / "robot.urdf") << urdf(robot_.model());
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angle(-1, 1);
  for (const double spread : {0.0, 1.0}) {
    walking::JointVector q;
    std::ofstream angles(folder / "angles");
    const std::vector<std::string> joints = joint_names();
    for (int joint = 0; joint < walking::kJoints; ++joint) {
      q[joint] = spread * angle(random);
      angles << joints[static_cast<std::size_t>(joint)] << ' ' << fmt::format("{}", q[joint]) << '\n';
    }
    angles.close();
    const std::string command = fmt::format(
        "/usr/bin/python3 '{}/tests/interop/read_urdf.py' '{}' '{}' > '{}'", GAITSLAM_SOURCE_DIR,
        (folder / "robot.urdf").string(), (folder / "angles").string(), (folder / "read").string());
    ASSERT_EQ(std::system(command.c_str()), 0);
    const std::vector<float> expected = robot_.poses({Eigen::Isometry3d::Identity(), q});
    std::ifstream read(folder / "read");
    std::size_t seen = 0;
    for (std::string name; read >> name;) {
      Eigen::Matrix<double, 3, 4, Eigen::RowMajor> X;
      for (double& number : X.reshaped<Eigen::RowMajor>()) read >> number;
      if (std::ranges::count(robot_.bodies(), name) == 0) continue;
      ++seen;
      EXPECT_TRUE(X.isApprox(pose(expected, name).matrix().topRows<3>(), 1e-5)) << name;
    }
    EXPECT_GE(seen, 29u);
  }
}

TEST_F(DrawnRobot, AsUrdfHasEveryShape) {
  const mjModel& model = robot_.model();
  const std::string text = urdf(model);
  std::size_t expected = 0, found = 0;
  for (int geom = 0; geom < model.ngeom; ++geom)
    if (moves(model, geom) && is_drawn(model, geom))
      expected += model.geom_type[geom] == mjGEOM_CAPSULE ? 3 : 1;
  for (std::size_t at = 0; (at = text.find("<visual>", at)) != text.npos; ++at) ++found;
  EXPECT_GT(expected, 60u);
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace sim::camera
