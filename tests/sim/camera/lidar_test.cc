#include "sim/camera/lidar.h"

#include "tests/sim/camera/test_cameras.h"

namespace sim::camera {
using namespace physics;
namespace {

using Eigen::Vector3d;
using std::chrono::milliseconds, std::chrono::nanoseconds;

// A robot that walks forward, sways, turns and shakes its head at the speeds of a brisk walk.
class LidarOfAWalk {
 public:
  explicit LidarOfAWalk(const std::string& room, rig::Lidar options = {})
      : model_(load_model(robot_file(), room, models())),
        data_(data_at_rest(*model_)),
        options_(options),
        place_(place_of(*model_, options_)),
        lidar_(copy_of(model_), place_, options_) {
    for (int k = 0; k <= 300; ++k) {
      const double t = 1e-3 * k;
      const Eigen::AngleAxisd turn(0.5 + 0.8 * t + 0.1 * std::sin(9 * t),
                                   Vector3d(0.05, 0.05, 1).normalized());
      const Eigen::Quaterniond q(turn);
      Eigen::Map<Eigen::Matrix<double, 7, 1>>(data_->qpos) << 0.5 + 0.4 * t, 0.03 * std::sin(7 * t),
          0.65 + 0.01 * std::sin(14 * t), q.w(), q.vec();
      for (int joint = 7; joint < model_->nq; ++joint) data_->qpos[joint] = 0.1 * std::sin(10 * t + joint);
      motion_.add(milliseconds(k), *model_, *data_);
    }
  }

  std::vector<slam::LidarPoint> scan(milliseconds begin, milliseconds end) {
    return lidar_.scan(motion_, begin, end);
  }
  /// The true X_WS for the joint angles at that time.
  Eigen::Isometry3d pose(nanoseconds t) const {
    return pose_of(*model_, *data_, motion_, place_, 1e-9 * double(t.count()));
  }
  /// The distance of the shape in a direction of the lidar, according to MuJoCo, and its geom.
  double cast(nanoseconds t, const Vector3d& along_S, int& geom) const {
    const Eigen::Isometry3d X_WS = pose(t);
    const Vector3d along = X_WS.linear() * along_S;
    constexpr mjtByte drawn[mjNGROUP] = {1, 1, 1, 0, 0, 0};
    return mj_ray(model_.get(), data_.get(), X_WS.translation().data(), along.data(), drawn, 1, place_.body,
                  &geom);
  }
  const mjModel& model() const { return *model_; }
  const rig::Lidar& options() const { return options_; }

 private:
  Model model_;
  Data data_;
  rig::Lidar options_;
  Place place_;
  Lidar lidar_;
  RecentMotion motion_{std::chrono::seconds(1)};
};

Vector3d position_of(const slam::LidarPoint& point) { return {point.x_m, point.y_m, point.z_m}; }

// The room's analytic surfaces share no code with MuJoCo's rays, and the pose is computed from the joint
// angles at the ray's own time. A ray along an edge may pass on either side of it.
TEST(Lidar, EachPointOfAMovingRobotLiesOnTheRoomAsSeenAtItsTimeAndGlassReturnsNone) {
  for (const std::string room : {"office", "hall"}) {
    LidarOfAWalk robot(room);
    std::map<std::int32_t, Vector3d> points;
    for (const slam::LidarPoint& point : robot.scan(milliseconds(100), milliseconds(200)))
      points[point.offset_ns] = position_of(point);
    const std::vector<score::Surface> surfaces = room_surfaces(robot.model());
    std::vector<int> geoms;
    for (int geom = 0; geom < robot.model().ngeom; ++geom)
      if (!moves(robot.model(), geom) && robot.model().geom_group[geom] == 0) geoms.push_back(geom);
    ASSERT_EQ(geoms.size(), surfaces.size());
    const Eigen::Isometry3d X_WS_begin = robot.pose(milliseconds(100));
    int on_room = 0, dark = 0, off = 0, off_without_own_pose = 0;
    for (int number = 20'000; number < 40'000; ++number) {
      const nanoseconds t = ray_time(robot.options(), number);
      const Eigen::Isometry3d X_WS = robot.pose(t);
      const Vector3d along_S = ray_direction(robot.options(), number), along = X_WS.linear() * along_S;
      const auto hit = score::first_surface(surfaces, X_WS.translation(), along);
      ASSERT_TRUE(hit.has_value());
      const auto point = points.find(std::int32_t((t - milliseconds(100)).count()));
      const bool seen = point != points.end(), bright = returns_light(robot.model(), geoms[hit->surface]);
      off += seen != bright;
      dark += !bright;
      if (!seen || !bright) continue;
      ++on_room;
      const Vector3d expected = X_WS.translation() + hit->distance * along;
      off += (X_WS * point->second - expected).norm() > 1e-3;
      off_without_own_pose += (X_WS_begin * point->second - expected).norm() > 1e-3;
    }
    EXPECT_GT(on_room, 15'000) << room;
    EXPECT_GT(dark, 50) << room;
    EXPECT_LE(off, 2) << room;
    EXPECT_GT(off_without_own_pose, on_room / 2) << "the robot moves";
    EXPECT_EQ(std::int64_t(points.size()), on_room);
  }
}

// MuJoCo casts these rays on the robot's shapes, too. In half a millisecond, a limb moves by less than a
// millimeter, but a ray that grazes it changes in length by several times as much.
TEST(Lidar, SeesOtherLinksOfTheRobotButNotItsOwn) {
  rig::Lidar down;
  down.lowest_rad = -1.5, down.highest_rad = -0.9;
  LidarOfAWalk robot("office", down);
  int on_robot = 0, off = 0;
  for (const slam::LidarPoint& point : robot.scan(milliseconds(0), milliseconds(20))) {
    const Vector3d p = position_of(point);
    int geom = -1;
    const double expected = robot.cast(nanoseconds(point.offset_ns), p.normalized(), geom);
    on_robot += moves(robot.model(), geom);
    off += std::abs(p.norm() - expected) > 5e-3;
  }
  EXPECT_GT(on_robot, 100);
  EXPECT_LE(off, 2) << "along an edge";
}

// Cells of equal height on a cylinder around the lidar have equal solid angles. With 200 000 rays in 36 x 6
// cells, the lines of the pattern leave 3 % of unevenness.
TEST(LidarPattern, FillsTheFieldOfViewEvenlyInASecondAndNeverRepeatsASweep) {
  const rig::Lidar options;
  constexpr int kAzimuths = 36, kHeights = 6;
  const double low = std::sin(options.lowest_rad), high = std::sin(options.highest_rad);
  std::array<int, kAzimuths * kHeights> counts{};
  for (int number = 0; number < options.points_per_s; ++number) {
    const Vector3d along = ray_direction(options, number);
    ASSERT_NEAR(along.norm(), 1, 1e-12);
    ASSERT_GE(along.z(), low - 1e-12);
    ASSERT_LE(along.z(), high + 1e-12);
    const double azimuth = std::atan2(along.y(), along.x()) / (2 * M_PI) + 0.5;
    const int column = std::min(int(azimuth * kAzimuths), kAzimuths - 1);
    const double height = (along.z() - low) / (high - low);
    ++counts[std::size_t(column + kAzimuths * std::min(int(height * kHeights), kHeights - 1))];
  }
  const double mean = double(options.points_per_s) / (kAzimuths * kHeights);
  for (const int count : counts) EXPECT_NEAR(count, mean, 0.03 * mean);
  const int sweep = int(options.points_per_s / options.rate_hz);
  for (int other = 1; other < 10; ++other)
    EXPECT_GT((ray_direction(options, 7) - ray_direction(options, 7 + other * sweep)).norm(), 1e-3);
}

TEST(LidarPattern, RaysAreEvenlySpacedInTimeForHours) {
  rig::Lidar options;
  options.points_per_s = 3'000'000;
  const std::int64_t number = 3'000'000ll * 36'000 + 1;
  EXPECT_EQ(ray_time(options, number).count(), 36'000'000'000'000ll + 333);
}

// The points of a lidar that hangs in the air among shapes that are white, painted gray, or covered by a gray
// picture.
std::vector<slam::LidarPoint> points_among(const Model& model, rig::Lidar options = {}) {
  const Data data = data_at_rest(*model);
  RecentMotion motion(milliseconds(10));
  motion.add(nanoseconds(0), *model, *data);
  options.lowest_rad = -M_PI / 2, options.highest_rad = M_PI / 2;
  Lidar lidar(copy_of(model), {mj_name2id(model.get(), mjOBJ_BODY, "head"), Eigen::Isometry3d::Identity()},
              options);
  return lidar.scan(motion, nanoseconds(0), milliseconds(100));
}

const char kHead[] =
    "<worldbody><body name='head'><freejoint/><geom type='sphere' size='0.01' mass='1'/></body></worldbody>";

TEST(Lidar, ReturnsNoPointOutsideItsRange) {
  const Model model =
      small_model("<worldbody><geom type='plane' size='9 9 1' pos='0 0 -1'/></worldbody>", kHead);
  rig::Lidar narrow;
  narrow.nearest_m = 2, narrow.furthest_m = 4;
  std::size_t expected = 0;
  for (const slam::LidarPoint& point : points_among(model))
    expected += position_of(point).norm() >= 2 && position_of(point).norm() < 4;
  EXPECT_EQ(points_among(model, narrow).size(), expected);
  EXPECT_GT(expected, 1000u);
}

// A ridge along y, 1 m high, below the lidar.
TEST(Lidar, SeesAHeightFieldAtItsKnownHeight) {
  const Model model = small_model(
      "<asset><hfield name='f' nrow='3' ncol='3' size='2 3 1 0.1'/></asset>"
      "<worldbody><geom type='hfield' hfield='f' pos='0 0 -1.5'/></worldbody>",
      kHead);
  for (const int row : {0, 1, 2}) model->hfield_data[3 * row + 1] = 1;
  const std::vector<slam::LidarPoint> points = points_among(model);
  for (const slam::LidarPoint& p : points) ASSERT_NEAR(p.z_m, -0.5 - std::abs(p.x_m) / 2, 1e-5);
  double furthest = 0, low = 0;
  for (const slam::LidarPoint& p : points)
    furthest = std::max(furthest, double(p.y_m)), low = std::min(low, double(p.z_m));
  EXPECT_GT(points.size(), 3000u);
  EXPECT_NEAR(furthest, 3, 0.1);
  EXPECT_NEAR(low, -1.5, 0.05);
}

TEST(Lidar, SeesWhatIsBehindGlassOfAGeomOrAMaterial) {
  const auto points = [](const std::string& pane) {
    return points_among(small_model("<asset><material name='m' rgba='1 1 1 0.3'/></asset><worldbody>" + pane +
                                        "<geom type='sphere' size='2'/></worldbody>",
                                    kHead));
  };
  const std::size_t all = points("").size();
  EXPECT_GT(all, 10'000u);
  for (const char* paint : {"rgba='1 1 1 0.99'", "material='m'"}) {
    const auto seen = points("<geom type='box' size='1 1 1' " + std::string(paint) + "/>");
    EXPECT_EQ(seen.size(), all);
    for (const slam::LidarPoint& point : seen) ASSERT_NEAR(position_of(point).norm(), 2, 1e-5);
  }
  for (const slam::LidarPoint& point : points("<geom type='box' size='1 1 1' rgba='1 1 1 1'/>"))
    ASSERT_LT(position_of(point).norm(), 1.8);
}

// Normals come from neighboring points of the surfaces. A turn by a tenth of a milliradian crosses an edge
// for only a few rays.
TEST(Lidar, IntensityOnWhiteIsTheCosineOfTheAngleOfIncidenceOnEachShape) {
  std::map<std::string, std::string> shapes{
      {"plane", "0.5 0.6 1"},  {"box", "0.3 0.2 0.4"},       {"sphere", "0.4"},
      {"cylinder", "0.3 0.5"}, {"ellipsoid", "0.2 0.3 0.5"}, {"capsule", "0.2 0.3"}};
  for (const auto& [type, size] : shapes) {
    const Model model = small_model("<worldbody><geom type='" + type + "' size='" + size +
                                        "' pos='1 0.3 0.2' euler='20 -70 10' rgba='1 1 1 1'/></worldbody>",
                                    kHead);
    const auto surfaces = room_surfaces(*model);
    int count = 0, off = 0;
    for (const slam::LidarPoint& point : points_among(model)) {
      const Vector3d p = position_of(point), along = p.normalized(), side = along.unitOrthogonal();
      std::array<Vector3d, 2> edges;
      bool missed = false;
      for (const int i : {0, 1}) {
        const Vector3d turned = (along + 1e-4 * (i ? side : along.cross(side))).normalized();
        const auto hit = score::first_hit(surfaces, Vector3d::Zero(), turned);
        missed |= !hit;
        edges[std::size_t(i)] = hit.value_or(0) * turned - p;
      }
      const double cosine = std::abs(along.dot(edges[0].cross(edges[1]).normalized()));
      ++count;
      off += missed || std::abs(point.intensity - cosine) > 0.01;
    }
    EXPECT_GT(count, 50) << type;
    EXPECT_LT(off, 0.03 * count) << type;
  }
}

TEST(Lidar, IntensityIsTheProductOfPaintAndPictureGray) {
  const Model model = small_model(
      "<asset><texture name='t' type='2d' builtin='flat' width='8' height='8' rgb1='0.6 0.6 0.6'/>"
      "<material name='m' texture='t' rgba='0.5 0.5 0.5 1'/></asset><worldbody>"
      "<geom type='plane' size='2 2 1' pos='0 0 -1' material='m'/>"
      "<geom type='plane' size='2 2 1' pos='0 0 1' zaxis='0 0 -1' rgba='1 0 0 1'/></worldbody>",
      kHead);
  for (const slam::LidarPoint& point : points_among(model)) {
    const double gray = point.z_m < 0 ? 0.3 : 0.299;
    EXPECT_NEAR(point.intensity, gray / position_of(point).norm(), 2e-3);
  }
}

// A person walks 1 m towards a robot that stands.
TEST(Actors, AreSeenWhereTheyAreAtTheTimeByCameraDepthCameraAndLidar) {
  const Model model =
      load_model(robot_file(), "floor", models(), Shapes::all, {Person{{{0, 3, 0}, {1, 2, 0}}}});
  const Data data = data_at_rest(*model);
  RecentMotion motion(std::chrono::seconds(2));
  for (int ms = 0; ms <= 1100; ++ms) motion.add(milliseconds(ms), *model, *data);
  rig::Lidar options;
  Lidar lidar(copy_of(model), place_of(*model, options), options);
  HeadCamera camera(copy_of(model), CameraOptions{});
  std::vector<double> ranges, depths;
  std::vector<cv::Mat> images;
  for (const int ms : {0, 1000}) {
    double nearest = 100;
    for (const slam::LidarPoint& point : lidar.scan(motion, milliseconds(ms), milliseconds(ms + 100)))
      if (std::abs(point.y_m) < 0.05 && point.x_m > 0.5 && point.z_m > -0.5)
        nearest = std::min(nearest, double(point.x_m));
    ranges.push_back(nearest);
    const Exposure exposure = camera.expose(motion, milliseconds(ms), {}, true);
    images.push_back(camera.image(exposure));
    const cv::Mat1w depth = camera.depth_mm(exposure);
    depths.push_back(1e-3 * depth(depth.rows / 2, depth.cols / 2));
  }
  EXPECT_NEAR(ranges[0] - ranges[1], 0.95, 0.06) << "walks on while the lidar turns";
  EXPECT_NEAR(depths[0] - depths[1], 1, 0.07) << "the camera looks at another height of the trunk";
  EXPECT_NEAR(depths[0], ranges[0], 0.3);
  EXPECT_GT(cv::norm(images[0], images[1], cv::NORM_INF), 20);
}

}  // namespace
}  // namespace sim::camera
