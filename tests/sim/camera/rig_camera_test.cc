#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/rig/rig.h"
#include "tests/sim/camera/test_cameras.h"

namespace sim::camera {
using namespace physics;
namespace {

using Eigen::Vector2d, Eigen::Vector3d;
using std::chrono::nanoseconds;

// The robot at its reference posture, at a place in the room and turned by a yaw.
RecentMotion standing_at(const mjModel& model, const Vector3d& p, double yaw) {
  const Data data = data_at_rest(model);
  Eigen::Map<Eigen::Matrix<double, 7, 1>>(data->qpos) << p, std::cos(yaw / 2), 0, 0, std::sin(yaw / 2);
  RecentMotion motion(nanoseconds(0));
  motion.add(nanoseconds(0), model, *data);
  return motion;
}

// Optical axes in W.
Eigen::Isometry3d pose_in_world(const mjModel& model, const RecentMotion& motion, const rig::Mount& mount) {
  const Data data = data_at_rest(model);
  return pose_of(model, *data, motion, place_of(model, mount), 0) *
         rig::camera_from_forward_left_up().inverse();
}

struct Compared {
  int exact = 0, off = 0, edges = 0, none = 0;
};

// Each pixel's depth against the analytic surface on its ray. Pixels are not compared where their neighbors
// meet another surface, on round surfaces, which are drawn with 20 sides, and on the robot's own arms.
Compared compare(const std::string& room, const CameraOptions& options, const rig::Mount& mount,
                 Channels channels) {
  Model model = load_model("hrp2", room, models());
  const std::vector<score::Surface> surfaces = room_surfaces(*model);
  std::vector<bool> returns;
  for (int geom = 0; geom < model->ngeom; ++geom)
    if (!moves(*model, geom) && model->geom_group[geom] == 0) returns.push_back(returns_light(*model, geom));
  HeadCamera camera(copy_of(model), options, 1, channels, mount);
  const slam::Camera seen = filter_camera(camera_model(options));
  Compared all;
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
          ++all.edges;
        } else if (!returns[here->surface]) {
          ++all.none;
          EXPECT_EQ(measured, 0) << "a window pane or a screen at " << u << " " << v;
        } else {
          const double expected = here->distance * seen.unproject(Vector2d(u, v))->h.normalized().z();
          ++(std::abs(measured - expected) <= 1e-3 ? all.exact : all.off);
        }
      }
  }
  return all;
}

// Faces of a box meet in creases, where a pixel's neighbors are on one surface but not on one plane.
void expect_exact(const Compared& all) {
  EXPECT_GE(all.exact, 10000);
  EXPECT_LT(all.off, 0.005 * all.exact);
  EXPECT_LT(all.edges, 0.6 * all.exact);
  EXPECT_GT(all.none, 50);
}

TEST(DepthCamera, IsExactToAMillimeterOnTheSurfacesOfTheOffice) {
  expect_exact(compare("office", {}, {}, Channels::grey));
}

TEST(DepthCamera, IsExactThroughAnotherLensInAnotherPlace) {
  CameraOptions options;
  options.width_px = 424, options.height_px = 240, options.fov_rad = 1.5, options.distortion = 0;
  rig::Mount mount;
  mount.position_m = {0.02, 0.1, -0.05};
  mount.yaw_rad = 0.3, mount.tilt_rad = 0.2, mount.roll_rad = 0.1;
  expect_exact(compare("hall", options, mount, Channels::rgb));
}

Model ball_at(const Vector3d& p, const std::string& rgba) {
  return head_in(
      fmt::format("<geom type='sphere' size='0.08' pos='{} {} {}' rgba='{}'/>", p.x(), p.y(), p.z(), rgba));
}

// The ball's center of gravity in both images, averaged over places a third of a pixel apart: the right eye's
// is on the epipolar line, a disparity of f b / z to the left.
TEST(RightEye, AgreesWithTheLeftOneByTheEpipolarGeometry) {
  CameraOptions options;
  options.distortion = 0;
  rig::Mount right;
  right.position_m = {0, -0.05, 0};
  for (const Vector3d& p : {Vector3d(1.5, 0.1, 0.1), Vector3d(3, -0.9, 0.3), Vector3d(0.9, 0.3, -0.3)}) {
    Vector2d off(0, 0);
    for (int step = 0; step < 6; ++step) {
      const Vector3d at = p + Vector3d(0, 0.0017, 0.0011) * step * p.x();
      HeadCamera left(ball_at(at, "1 1 1 1"), options),
          other(ball_at(at, "1 1 1 1"), options, 1, Channels::grey, right);
      const Data plant = data_at_rest(left.model());
      const auto center_in = [&plant](HeadCamera& camera) {
        const cv::Mat1b image = camera.render(*plant);
        return centroid({0, 0, image.cols, image.rows}, [&](int u, int v) { return double(image(v, u)); });
      };
      const Vector2d l = center_in(left), r = center_in(other);
      off += (l - r - Vector2d(camera_model(options).fu_px * 0.05 / at.x(), 0)) / 6;
    }
    EXPECT_LT(off.norm(), 0.1) << p.transpose();
  }
}

// Both cameras draw, so that neither has the state of the other.
TEST(RightEye, WithTheTexturesOfTheLeftOneDrawsTheSamePicturesAsWithItsOwn) {
  const Model model = load_model("hrp2", "office", models());
  rig::Mount right;
  right.position_m = {0, -0.05, 0};
  HeadCamera left(copy_of(model), {}), own(copy_of(model), {}, 1, Channels::grey, right),
      shared(copy_of(model), {}, 1, Channels::grey, right, &left);
  const Data plant = data_at_rest(*model);
  const cv::Mat seen_left = left.render(*plant), expected = own.render(*plant);
  EXPECT_EQ(cv::norm(shared.render(*plant), expected, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(left.render(*plant), seen_left, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(seen_left, expected, cv::NORM_INF), 50);
}

TEST(ColorCamera, GivesRedGreenAndBlueInThatOrder) {
  HeadCamera camera(ball_at({2, 0, 0}, "1 0.5 0 1"), {}, 1, Channels::rgb);
  const cv::Mat3b image = camera.render(*data_at_rest(camera.model()));
  EXPECT_EQ(image(127, 157), cv::Vec3b(255, 128, 0));
}

TEST(Shutter, ExposesEachChannelAsItsOwnPicture) {
  CameraOptions options;
  options.readout_s = 0.01, options.height_px = 32, options.subframes = 3;
  std::vector<cv::Mat> colors, greens;
  for (int i = 0; i < 3; ++i) {
    colors.push_back(cv::Mat3b(32, 4, cv::Vec3b(10, uchar(50 * i), 200)));
    greens.push_back(cv::Mat1b(32, 4, uchar(50 * i)));
  }
  const cv::Mat3b color = Shutter(options).expose(colors);
  const cv::Mat1b green = Shutter(options).expose(greens);
  for (int row = 0; row < 32; ++row) EXPECT_EQ(color(row, 1), cv::Vec3b(10, green(row, 1), 200));
}

TEST(Mount, TiltsTheHeadCameraOfTheModelDownwards) {
  Model model = load_model("hrp2", "office", models());
  const RecentMotion motion = standing_at(*model, {0, 0, 0.65}, 0);
  const Vector3d before = pose_in_world(*model, motion, {}).linear().col(2);
  rig::Mount mount;
  mount.tilt_rad = 0.3;
  mount_camera(*model, mount);
  const Vector3d after = pose_in_world(*model, motion, {}).linear().col(2);
  EXPECT_NEAR(before.z(), 0, 1e-12);
  EXPECT_NEAR(after.z(), -std::sin(0.3), 1e-12);
  mount.link = "CHEST_LINK1";
  EXPECT_EQ(place_of(*model, mount).body, mj_name2id(model.get(), mjOBJ_BODY, "CHEST_LINK1"));
  mount.link = "LLEG_LINK3";
  EXPECT_THROW(place_of(*model, mount), std::invalid_argument);
}

}  // namespace
}  // namespace sim::camera
