#include "sim/camera/head_camera.h"

#include "tests/sim/camera/test_cameras.h"

namespace sim::camera {
using namespace physics;
namespace {

using Eigen::Vector2d, Eigen::Vector3d;
using std::chrono::nanoseconds;

struct Ball {
  Vector3d p_W;
  double radius;
};

// Balls that cover the image, borders included, at depths from 0.6 to 6 m, each about 7 px in radius.
std::vector<Ball> balls_in_view(const slam::CameraIntrinsics& camera, const Eigen::Isometry3d& X_WC) {
  std::vector<Ball> balls;
  for (int i = 0; i < 35; ++i) {
    const Vector2d uv(camera.width_px * (i % 7 + 0.5) / 7, camera.height_px * (i / 7 + 0.5) / 5);
    const double depth = 0.6 * std::pow(10.0, (i * 5 % 35) / 34.0);
    balls.push_back({X_WC * (depth * direction(camera, uv).homogeneous()), depth * 7 / camera.fu_px});
  }
  return balls;
}

// Uses the filter's camera model, which shares no code with the renderer's lens.
Vector2d expected_centroid(const slam::Camera& seen, const cv::Rect& window, const Vector3d& p_C,
                           double radius) {
  return centroid(window, [&](int u, int v) {
    constexpr int parts = 4;
    int covered = 0;
    for (int part = 0; part < parts * parts; ++part) {
      const Vector2d in_pixel((part % parts + 0.5) / parts - 0.5, (part / parts + 0.5) / parts - 0.5);
      const Vector3d ray = seen.unproject(Vector2d(u, v) + in_pixel)->h.normalized();
      covered += ray.cross(p_C).norm() < radius;
    }
    return double(covered);
  });
}

Eigen::Isometry3d pose_of_camera(const Vector3d& p, const Eigen::Quaterniond& q) {
  Eigen::Matrix3d R_HC;  // optical axes in the head's: x right = -y, y down = -z, z ahead = x
  R_HC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Eigen::Translation3d(p) * q * Eigen::Isometry3d(Eigen::AngleAxisd(R_HC));
}

// Cameras with the paper's lens, with the strongest lens, and without distortion.
std::vector<CameraOptions> all_cameras() {
  std::vector<CameraOptions> cameras;
  for (double distortion : {1.0, 1.3, 0.0})
    for (int width : {320, 640}) {
      CameraOptions& options = cameras.emplace_back();
      options.width_px = width, options.height_px = width * 3 / 4, options.distortion = distortion;
    }
  return cameras;
}

CameraOptions camera(double exposure_s, double readout_s, int subframes) {
  CameraOptions options;
  options.exposure_s = exposure_s, options.readout_s = readout_s, options.subframes = subframes;
  return options;
}

// Each ball's error is averaged over poses that shift the image by fractions of a pixel. The steps of its
// edge cancel out; an error of the lens, of half a pixel or of the pose would not.
TEST(HeadCamera, ShowsKnownPointsWithinATenthOfAPixelOverTheWholeImage) {
  constexpr int poses = 6;
  const Vector3d p(0.3, -0.2, 1.4);
  const Eigen::Quaterniond q(Eigen::AngleAxisd(0.7, Vector3d(0.1, -0.2, 0.9).normalized()));
  for (const CameraOptions& options : all_cameras()) {
    const slam::CameraIntrinsics model = camera_model(options);
    const slam::Camera seen(model);
    const std::vector<Ball> balls = balls_in_view(model, pose_of_camera(p, q));
    std::string room;
    for (const auto& [c, radius] : balls)
      room += fmt::format("<geom type='sphere' size='{}' pos='{} {} {}' rgba='1 1 1 1'/>", radius, c.x(),
                          c.y(), c.z());
    HeadCamera camera(head_in(room), options);
    const Data plant = data_at_rest(camera.model());
    std::vector<Vector2d> error(balls.size(), Vector2d::Zero());
    for (int pose = 0; pose < poses; ++pose) {
      const Vector3d turn(0, 0.0017 * pose, 0.0011 * pose);  // rad: a third of a pixel from pose to pose
      const Eigen::Quaterniond q_pose = q * Eigen::AngleAxisd(turn.norm(), turn.stableNormalized());
      Eigen::Map<Eigen::Matrix<double, 7, 1>>(plant->qpos) << p, q_pose.w(), q_pose.vec();
      const cv::Mat1b image = camera.render(*plant);
      for (std::size_t i = 0; i < balls.size(); ++i) {
        const Vector3d p_C = pose_of_camera(p, q_pose).inverse() * balls[i].p_W;
        const Vector2d uv = seen.project(p_C)->pixel;
        const cv::Rect window = cv::Rect(int(uv.x()) - 13, int(uv.y()) - 13, 27, 27) &
                                cv::Rect(0, 0, model.width_px, model.height_px);
        error[i] += (centroid(window, [&](int u, int v) { return double(image(v, u)); }) -
                     expected_centroid(seen, window, p_C, balls[i].radius)) /
                    poses;
      }
    }
    for (const Vector2d& e : error) EXPECT_LT(e.norm(), 0.1) << options.width_px;
    const Vector2d sum = std::accumulate(error.begin(), error.end(), Vector2d(0, 0));
    EXPECT_LT(sum.norm() / double(error.size()), 0.02);  // a forgotten half pixel would show here first
  }
}

TEST(HeadCamera, DoesNotSeeTheHeadItSitsIn) {
  HeadCamera camera(head_in("<geom type='sphere' size='1' pos='0 0 -50'/>"), CameraOptions{});
  EXPECT_EQ(cv::countNonZero(camera.render(*data_at_rest(camera.model()))), 0);
}

// The lamps go off in the middle of the frame: each row gets their light for its own part of the exposure.
TEST(HeadCamera, RowsKeepFifteenPercentOfTheLightWhileTheLampsAreOff) {
  const auto row_level = [](double exposure_s, double readout_s, int ms, int row, double light = 1) {
    const CameraOptions options = camera(exposure_s, readout_s, 21);
    HeadCamera camera(
        head_in(
            "<geom type='plane' size='20 20 50' pos='3 0 0' xyaxes='0 -1 0 0 0 1' rgba='0.8 0.8 0.8 1'/>"),
        options);
    RecentMotion motion(options.lead());
    motion.add(std::chrono::seconds(0), camera.model(), *data_at_rest(camera.model()));
    WorldOptions world;
    world.lights_off = {2, 1}, world.light.level = light;
    return cv::mean(camera.image(camera.expose(motion, std::chrono::milliseconds(ms), world)).row(row))[0];
  };
  for (const auto& [ms, level] : {std::pair(1999, 204), {2000, 31}, {2999, 31}, {3000, 204}})
    EXPECT_NEAR(row_level(0, 0, ms, 120), level, 1) << ms;
  EXPECT_NEAR(row_level(0, 0, 1000, 120, 0.5), 102, 1) << "half of the light";
  EXPECT_NEAR(row_level(0, 0, 2000, 120, 0.5), 15, 1) << "of which 15 % are left";
  EXPECT_NEAR(row_level(0.02, 0, 2000, 20), (204 + 31) / 2, 8);
  for (const auto& [row, level] : {std::pair(20, 204), {100, 204}, {140, 31}, {220, 31}})
    EXPECT_NEAR(row_level(0, 0.02, 2000, row), level, 1) << row;
}

TEST(Shutter, AnInstantaneousExposureIsOnePictureAtTheStamp) {
  const Shutter shutter(camera(0, 0, 8));
  EXPECT_EQ(shutter.moments(), std::vector<double>{0});
  EXPECT_EQ(camera(0, 0, 8).lead().count(), 0);
  const cv::Mat1b picture(240, 320, uchar(77));
  EXPECT_EQ(shutter.expose({picture}).data, picture.data);
  EXPECT_EQ(camera(0.01, 0.016, 9).lead().count(), 13);  // other shutters: when they have closed
  EXPECT_EQ(camera(0.005, 0, 9).lead().count(), 3);
}

// Pictures whose green brightens evenly from 0 to 200: a row is as bright as the light at its own moment, and
// the other channels are not mixed with it.
TEST(Shutter, UnderGrowingLightEachRowHasTheBrightnessOfItsMoment) {
  for (auto [exposure, readout] : {std::pair(0.01, 0.0), std::pair(0.0, 0.01), std::pair(0.01, 0.03)}) {
    std::vector<cv::Mat> growing;
    for (int i = 0; i < 9; ++i) growing.push_back(cv::Mat3b(240, 4, cv::Vec3b(10, uchar(25 * i), 200)));
    const cv::Mat3b rows = Shutter(camera(exposure, readout, 9)).expose(growing);
    for (int row = 0; row < 240; ++row) {
      const double moment = readout * ((row + 0.5) / 240 - 0.5) / (exposure + readout);
      const cv::Vec3b found = rows(row, 2);
      ASSERT_NEAR(found[1], 100 + 200 * moment, 0.51) << row;  // rounded to whole levels
      ASSERT_TRUE(found[0] == 10 && found[2] == 200) << row;
    }
  }
}

TEST(RecentMotion, InterpolatesLinearlyAndTurnsTheShortWay) {
  const physics::Model model = physics::load_model(physics::robot_file(), "floor", physics::models());
  const physics::Data data = data_at_rest(*model);
  RecentMotion motion(std::chrono::milliseconds(3));
  for (int ms = 0; ms < 10; ++ms) {
    const double yaw = 0.02 * ms;
    data->qpos[0] = 0.5 * ms;
    data->qpos[3] = std::cos(yaw / 2), data->qpos[6] = std::sin(yaw / 2);
    motion.add(std::chrono::milliseconds(ms), *model, *data);
  }
  const Eigen::VectorXd q = motion.at(0.00725, *model);
  EXPECT_NEAR(q[0], 3.625, 1e-12);
  EXPECT_NEAR(2 * std::atan2(q[6], q[3]), 0.145, 1e-12);
  EXPECT_NEAR(motion.at(0.009, *model)[0], 4.5, 1e-12);
  EXPECT_NEAR(motion.at(0.1, *model)[0], 4.5, 1e-12);  // nothing later is known
  EXPECT_NEAR(motion.at(0.0, *model)[0], 2.5, 0.51);   // motion older than its limit is no longer kept
}

// The robot in its reference posture, at a place in the room and with a yaw.
RecentMotion standing_at(const mjModel& model, const Vector3d& p, double yaw) {
  const Data data = data_at_rest(model);
  Eigen::Map<Eigen::Matrix<double, 7, 1>>(data->qpos) << p, std::cos(yaw / 2), 0, 0, std::sin(yaw / 2);
  RecentMotion motion(nanoseconds(0));
  motion.add(nanoseconds(0), model, *data);
  return motion;
}

// The pose of the optical axes in W.
Eigen::Isometry3d pose_in_world(const mjModel& model, const RecentMotion& motion, const rig::Mount& mount) {
  const Data data = data_at_rest(model);
  return pose_of(model, *data, motion, place_of(model, mount), 0) *
         rig::camera_from_forward_left_up().inverse();
}

// Compares each pixel's depth with the analytic surface on its ray. Pixels are skipped if their neighbors are
// on another surface, on round surfaces (which are drawn with 20 sides), and on the robot's own arms. In
// the creases between the faces of a box, a pixel's neighbors are on one surface but not on one plane.
void expect_exact_depth(const std::string& room, const CameraOptions& options, const rig::Mount& mount,
                        Channels channels) {
  Model model = load_model(robot_file(), room, models());
  const std::vector<score::Surface> surfaces = room_surfaces(*model);
  std::vector<bool> returns;
  for (int geom = 0; geom < model->ngeom; ++geom)
    if (!moves(*model, geom) && model->geom_group[geom] == 0) returns.push_back(returns_light(*model, geom));
  HeadCamera camera(copy_of(model), options, 1, channels, mount);
  const slam::Camera seen(camera_model(options));
  int exact = 0, off = 0, edges = 0, none = 0;
  for (const auto& [x, y, yaw] : {std::array{0.0, 0.0, 0.0}, {0.7, 0.4, 1.9}}) {
    const RecentMotion motion = standing_at(*model, {x, y, 0.65}, yaw);
    const Eigen::Isometry3d X_WS = pose_in_world(*model, motion, mount);
    const cv::Mat1w depth = camera.depth_mm(camera.expose(motion, nanoseconds(0), {}, true));
    for (int v = 2; v < options.height_px - 2; v += 3)
      for (int u = 2; u < options.width_px - 2; u += 3) {
        const auto hit = [&](int du, int dv) {
          const Vector3d ray = X_WS.linear() * seen.unproject(Vector2d(u + du, v + dv))->h.normalized();
          return score::first_surface(surfaces, X_WS.translation(), ray);
        };
        const auto here = hit(0, 0);
        const bool flat = here && (surfaces[here->surface].kind == score::Surface::Kind::plane ||
                                   surfaces[here->surface].kind == score::Surface::Kind::box);
        bool same = flat;
        for (const auto& [du, dv] :
             {std::pair(-2, 0), {2, 0}, {0, -2}, {0, 2}, {-2, -2}, {2, 2}, {2, -2}, {-2, 2}})
          if (const auto near = hit(du, dv); !near || !here || near->surface != here->surface) same = false;
        const double measured = 1e-3 * depth(v, u);
        if (!same) {
          ++edges;
        } else if (!returns[here->surface]) {
          ++none;
          EXPECT_EQ(measured, 0) << "a window pane or a screen at " << u << " " << v;
        } else {
          const double expected = here->distance * seen.unproject(Vector2d(u, v))->h.normalized().z();
          ++(std::abs(measured - expected) <= 1e-3 ? exact : off);
        }
      }
  }
  EXPECT_GE(exact, 10000);
  EXPECT_LT(off, 0.005 * exact);
  EXPECT_LT(edges, 0.6 * exact);
  EXPECT_GT(none, 50);
}

TEST(DepthCamera, IsAccurateToAMillimeterOnTheSurfacesOfTheOffice) {
  expect_exact_depth("office", {}, {}, Channels::gray);
}

TEST(DepthCamera, IsAccurateWithAnotherLensInAnotherPlace) {
  CameraOptions options;
  options.width_px = 424, options.height_px = 240, options.fov_rad = 1.5, options.distortion = 0;
  rig::Mount mount;
  mount.position_m = {0.02, 0.1, -0.05};
  mount.yaw_rad = 0.3, mount.tilt_rad = 0.2, mount.roll_rad = 0.1;
  expect_exact_depth("hall", options, mount, Channels::rgb);
}

// Draws with both cameras, so that neither can inherit the other's state.
TEST(RightEye, DrawsTheSamePicturesWithTheLeftEyesTexturesAsWithItsOwn) {
  const Model model = load_model(robot_file(), "office", models());
  rig::Mount right;
  right.position_m = {0, -0.05, 0};
  HeadCamera left(copy_of(model), {}), own(copy_of(model), {}, 1, Channels::gray, right),
      shared(copy_of(model), {}, 1, Channels::gray, right, &left);
  const Data plant = data_at_rest(*model);
  const cv::Mat seen_left = left.render(*plant), expected = own.render(*plant);
  EXPECT_EQ(cv::norm(shared.render(*plant), expected, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(left.render(*plant), seen_left, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(seen_left, expected, cv::NORM_INF), 50);
}

TEST(Renderer, IsUsedByOneThreadAtATime) {
  Renderer one({8, 8}, Channels::gray), other({8, 8}, Channels::gray);
  auto held = one.use();
  const auto beside = std::async(std::launch::async, [&] { const auto lock = other.use(); });
  EXPECT_EQ(beside.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
  held.unlock();
  beside.wait();
}

TEST(Mount, IsAtItsPositionAndTiltsTheModelsHeadCameraDownwards) {
  Model model = load_model(robot_file(), "office", models());
  const RecentMotion motion = standing_at(*model, {0, 0, 0.65}, 0);
  const Eigen::Isometry3d X_WC = pose_in_world(*model, motion, {});
  rig::Mount mount, right;
  right.position_m = {0.03, -0.05, 0.02};  // ahead, left, up
  EXPECT_TRUE(pose_in_world(*model, motion, right).isApprox(X_WC * Eigen::Translation3d(0.05, -0.02, 0.03)));
  mount.tilt_rad = 0.3;
  mount_camera(*model, mount);
  EXPECT_NEAR(X_WC.linear()(2, 2), 0, 1e-12);
  EXPECT_NEAR(pose_in_world(*model, motion, {}).linear()(2, 2), -std::sin(0.3), 1e-12);
  mount.link = "CHEST_LINK1";
  EXPECT_EQ(place_of(*model, mount).body, part(*model, mjOBJ_BODY, "CHEST_LINK1"));
  mount.link = "LLEG_LINK3";
  EXPECT_THROW(place_of(*model, mount), std::invalid_argument);
}

}  // namespace
}  // namespace sim::camera
