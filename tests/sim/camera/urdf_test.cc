#include "sim/camera/urdf.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <random>

#include "sim/camera/drawn_model.h"
#include "sim/camera/shapes.h"
#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/physics/half_sitting_world.h"
#include "tests/sim/physics/small_model.h"

namespace sim::camera {
using namespace physics;
namespace {

// An independent reader of the format puts every link where the simulator puts its body.
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
