#include "sim/camera/drawn_model.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <bit>
#include <set>

#include "tests/sim/physics/half_sitting_world.h"

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
}  // namespace sim::camera
