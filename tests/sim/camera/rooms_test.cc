#include <bit>
#include <opencv2/imgproc.hpp>

#include "sim/camera/drawn_model.h"
#include "sim/camera/head_camera.h"
#include "sim/room/paint.h"
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

Model robot_in(const std::string& room) { return load_model(robot_file(), room, models()); }

// A furnished room: its middle and size, and how much space is free around the circles walked, m.
struct Room {
  std::string name;
  Vector2d middle;
  Vector3d size;
  double free;
};
const Room kOffice{"office", {0.9, 0.15}, {11, 7, 3}, 2}, kHall{"hall", {0.9, 3.65}, {25, 18, 3}, 4};

bool is_shell(const score::Surface& s) {
  return s.kind == score::Surface::Kind::plane && s.size.prod() == 0 && s.size.maxCoeff() > 3;
}

// The hall of 11 x 25 m and the adjacent open office of 7 x 25 m are one space.
TEST(Rooms, HaveTheirSizeContainEverythingAndLeaveMetersFreeAroundTheWalk) {
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
      // Geoms above the robot or in the floor are not in its way.
      if (is_shell(surface) || box.min().z() > 2 || box.max().z() < 0.002) continue;
      const Vector2d away = ((center.head<2>() - walked).cwiseAbs() - half.head<2>()).cwiseMax(0);
      EXPECT_GT(away.norm(), room.free) << room.name << " " << center.transpose();
    }
    EXPECT_LT((shell.sizes() - room.size).norm(), 1e-9) << room.name;
    EXPECT_LT((shell.center().head<2>() - room.middle).norm(), 1e-9) << room.name;
    EXPECT_NEAR(shell.min().z(), 0, 1e-12);
  }
}

TEST(Rooms, EachTextureHasAPainterThatDependsOnlyOnNameAndSeed) {
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
    const double yaw = step * 2 * CV_PI / 16;  // on the tangent circle, 0.75 m about (1, 0.25)
    Eigen::Map<Eigen::Matrix<double, 7, 1>>(plant->qpos) << 1 + 0.75 * std::sin(yaw),
        0.25 - 0.75 * std::cos(yaw), on_floor().robot.base_height, std::cos(yaw / 2), 0, 0, std::sin(yaw / 2);
    const cv::Mat1b image = camera.render(*plant);
    cv::Mat1f strength;
    cv::cornerMinEigenVal(image, strength, 11, 3);
    std::vector<cv::Point2f> corners;
    cv::goodFeaturesToTrack(image, corners, 0, 1e-6, 10, strength > kThreshold, 11);
    std::set<int> twelfths;
    for (const cv::Point2f& corner : corners) twelfths.insert(int(corner.x) / 80 + 4 * (int(corner.y) / 80));
    EXPECT_GE(corners.size(), 30u) << step;  // two and a half times the number that the filter keeps in view
    EXPECT_GE(twelfths.size(), 7u) << step;
  }
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

  PosedRobot robot_{robot_file(), "office", models()};
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
  std::size_t vertices = 0;
  std::set<int> bodies;
  Eigen::AlignedBox3f room;
  for (const DrawnPiece& piece : robot_.pieces()) {
    const std::size_t count = piece.positions.size() / 3;
    EXPECT_EQ(piece.normals.size(), 3 * count);
    EXPECT_EQ(piece.colors.size(), 3 * count);
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

TEST(DrawnRoom, GlassIsAPieceOfItsOwnWithItsAlpha) {
  const files::TemporaryFolder folder;
  files::write_text(folder / "room.xml",
                    "<mujoco><worldbody><geom name='floor' type='plane' size='5 5 1'/>"
                    "<geom type='box' size='1 1 1' pos='3 0 1' rgba='1 0 0 0.25'/></worldbody></mujoco>");
  std::vector<DrawnPiece> glass = PosedRobot(robot_file(), (folder / "room.xml").string(), models()).pieces();
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

TEST_F(DrawnRobot, UrdfPlacesItsLinksWhereTheModelHasItsBodies) {
  const files::TemporaryFolder folder;
  std::ofstream(folder / "robot.urdf") << urdf(robot_.model());
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angle(-1, 1);
  for (const double spread : {0.0, 1.0}) {
    walking::JointVector q(30);
    std::ofstream angles(folder / "angles");
    for (int joint = 0; joint < q.size(); ++joint) {
      q[joint] = spread * angle(random);
      angles << robot_.robot().joints[static_cast<std::size_t>(joint)].name << ' '
             << fmt::format("{}", q[joint]) << '\n';
    }
    angles.close();
    const std::string command = fmt::format(
        "/usr/bin/python3 '{}/tests/interop/read_exports.py' urdf '{}' '{}' > '{}'", GAITSLAM_SOURCE_DIR,
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

TEST_F(DrawnRobot, UrdfContainsEveryShape) {
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
