#include <bit>
#include <regex>

#include "sim/camera/drawn_model.h"
#include "sim/camera/head_camera.h"
#include "sim/physics/compiled.h"
#include "sim/room/paint.h"
#include "tests/sim/physics/test_worlds.h"

namespace sim::camera {
using namespace physics;
namespace {

// The planes of more than 6 m are floor, ceiling and walls; tests/sim/physics has where the walls are solid.
TEST(Rooms, AreDrawnWhereTheirWallsAreSolid) {
  using Eigen::Vector3d;
  for (const auto& [room, low, high] :
       {std::tuple("office", Vector3d(-4.6, -3.35, 0), Vector3d(6.4, 3.65, 3)),
        {"hall", Vector3d(-11.6, -5.35, 0), Vector3d(13.4, 12.65, 3)}}) {
    Eigen::AlignedBox3d shell;
    for (const score::Surface& s : room_surfaces(*load_model(robot_file(), room, models()))) {
      if (s.kind != score::Surface::Kind::plane || s.size.prod() != 0 || s.size.maxCoeff() <= 3) continue;
      const Vector3d center = s.X_WS.translation(), half = s.X_WS.linear().cwiseAbs() * s.size;
      shell.extend(Vector3d(center - half)), shell.extend(Vector3d(center + half));
    }
    EXPECT_LT((shell.min() - low).norm() + (shell.max() - high).norm(), 1e-9) << room;
  }
}

TEST(Rooms, EachTextureHasAPainterThatDependsOnlyOnNameAndSeed) {
  for (const char* room : {"office", "hall"}) {
    const Model model = load_model(robot_file(), room, models());
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

  PosedRobot robot_{robot_file(), {}, models()};
};

// The physics model has fewer shapes than the drawn one, but the same bodies.
TEST_F(DrawnRobot, HasItsBodiesWhereThePlantHasThem) {
  const World world = standing({}, kSomewhere);
  const std::vector<std::string>& names = robot_.bodies();
  const std::vector<float> plant = body_poses(*world.model(), *world.data(), names),
                           drawn = robot_.poses({world.X_WB(), half_sitting()});
  EXPECT_GE(names.size(), 29u);
  for (const std::string& body : names)  // float, and bushings that carry no weight yet
    EXPECT_TRUE(pose(plant, body).isApprox(pose(drawn, body), 1e-5)) << body;
  EXPECT_TRUE(pose(drawn, "BODY").isApprox(world.X_WB(), 1e-6));
  EXPECT_THROW(body_poses(*world.model(), *world.data(), {"TAIL"}), std::invalid_argument);
}

TEST_F(DrawnRobot, IsInsideItsRoomAndAllVerticesAreComplete) {
  std::set<int> bodies;
  Eigen::AlignedBox3f room;
  for (const DrawnPiece& piece : robot_.pieces()) {
    const std::size_t count = piece.positions.size() / 3;
    EXPECT_EQ(piece.normals.size(), 3 * count);
    EXPECT_EQ(piece.colors.size(), 3 * count);
    EXPECT_EQ(piece.uv.size(), piece.picture < 0 ? 0 : 2 * count);
    EXPECT_EQ(piece.indices.size() % 3, 0u);
    EXPECT_LT(*std::ranges::max_element(piece.indices), count);
    bodies.insert(piece.body);
    for (std::size_t i = 0; piece.body < 0 && i < piece.positions.size(); i += 3)
      room.extend(Eigen::Map<const Eigen::Vector3f>(&piece.positions[i]));
  }
  EXPECT_EQ(bodies.size(), robot_.bodies().size() + 1) << "each body, and the room";
  EXPECT_NEAR(room.min().z(), 0, 0.05);  // the floor
  EXPECT_GT(room.max().z(), 2.2f);       // the ceiling
}

TEST(DrawnRoom, GlassIsAPieceOfItsOwnWithItsAlpha) {
  const files::TemporaryFolder folder;
  files::write_text(folder / "room.xml",
                    "<mujoco><worldbody><geom name='floor' type='plane' size='5 5 1'/>"
                    "<geom type='box' size='1 1 1' pos='3 0 1' rgba='1 0 0 0.25'/></worldbody></mujoco>");
  std::vector<DrawnPiece> glass =
      PosedRobot(robot_file(), {.room = (folder / "room.xml").string()}, models()).pieces();
  std::erase_if(glass, [](const DrawnPiece& piece) { return piece.alpha >= 1; });
  ASSERT_EQ(glass.size(), 1u);
  EXPECT_EQ(glass[0].alpha, 0.25f);
  EXPECT_EQ(glass[0].body, -1);
  EXPECT_EQ(glass[0].indices.size(), 36u);
}

TEST_F(DrawnRobot, PicturesDependOnTheSeedAndHavePowerOfTwoSides) {
  const auto pictures = robot_.pictures(1, 64);
  EXPECT_GT(pictures.size(), 10u);
  EXPECT_GT(cv::norm(pictures[0], robot_.pictures(2, 64)[0]), 0);
  for (const cv::Mat3b& picture : pictures)
    for (const int side : {picture.cols, picture.rows})
      EXPECT_TRUE(side <= 64 && std::has_single_bit(unsigned(side))) << side;
}

// MuJoCo reads the URDF, for which each link needs a mass.
TEST_F(DrawnRobot, UrdfPlacesItsLinksWhereTheModelHasItsBodies) {
  const files::TemporaryFolder folder;
  files::write_text(folder / "robot.urdf",
                    std::regex_replace(urdf(robot_.model()), std::regex("<link [^>]*>"),
                                       "$&<inertial><mass value='1'/><inertia ixx='.01' iyy='.01' izz='.01' "
                                       "ixy='0' ixz='0' iyz='0'/></inertial>"));
  const CompiledRobot read = compile_robot(folder / "robot.urdf", "", {});
  const Data data(mj_makeData(read.model.get()));
  walking::JointVector q(30);
  for (int joint = 0; joint < q.size(); ++joint) {
    q[joint] = std::sin(joint);
    const int found = part(*read.model, mjOBJ_JOINT, robot_.robot().joints[std::size_t(joint)].name);
    data->qpos[read.model->jnt_qposadr[found]] = q[joint];
  }
  mj_kinematics(read.model.get(), data.get());
  const std::vector<float> expected = robot_.poses({Eigen::Isometry3d::Identity(), q});
  for (const std::string& body : robot_.bodies()) {
    if (body == "BODY") continue;  // the waist, which is the root
    const int id = part(*read.model, mjOBJ_BODY, body);
    const Eigen::Isometry3d X = pose_in(data->xpos + 3 * id, data->xmat + 9 * id);
    EXPECT_TRUE(X.isApprox(pose(expected, body), 1e-5)) << body;
  }
}

}  // namespace
}  // namespace sim::camera
