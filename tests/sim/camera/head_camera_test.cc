#include "sim/camera/head_camera.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numeric>
#include <opencv2/imgproc.hpp>
#include <string>

#include "slam/camera.h"
#include "tests/sim/physics/test_worlds.h"

namespace sim::camera {
using namespace physics;
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

// A robot that is nothing but a flying head camera, in a room of the given geoms.
Model head_in(const std::string& room) {
  return SmallModel(
             "<visual><headlight ambient='1 1 1' diffuse='0 0 0' specular='0 0 0'/></visual><worldbody>" +
                 room + "</worldbody>",
             "<worldbody><body name='head'><freejoint/><geom type='sphere' size='0.01' group='2'/>"
             "<camera name='head_camera' xyaxes='0 -1 0 0 0 1'/></body></worldbody>")
      .load();
}

struct Ball {
  Vector3d p_W;
  double radius;
};

std::string white_ball(const Ball& ball) {
  return fmt::format("<geom type='sphere' size='{}' pos='{} {} {}' rgba='1 1 1 1'/>", ball.radius,
                     ball.p_W.x(), ball.p_W.y(), ball.p_W.z());
}

// Balls that cover the image, borders included, at depths from 0.6 to 6 m, each about 7 px in radius.
std::vector<Ball> balls_in_view(const CameraModel& camera, const Eigen::Isometry3d& X_WC) {
  std::vector<Ball> balls;
  for (int i = 0; i < 35; ++i) {
    const Vector2d uv(camera.width_px * (i % 7 + 0.5) / 7, camera.height_px * (i / 7 + 0.5) / 5);
    const double depth = 0.6 * std::pow(10.0, (i * 5 % 35) / 34.0);
    balls.push_back({X_WC * (depth * camera.direction(uv).homogeneous()), depth * 7 / camera.fu_px});
  }
  return balls;
}

// Center of gravity of the pixels in a window, each weighted by `brightness`.
template <typename Brightness>
Vector2d centroid(const cv::Rect& window, Brightness brightness) {
  Vector2d sum(0, 0);
  double weight = 0;
  for (int v = window.y; v < window.y + window.height; ++v)
    for (int u = window.x; u < window.x + window.width; ++u) {
      const double w = brightness(u, v);
      sum += w * Vector2d(u, v), weight += w;
    }
  return sum / weight;
}

Vector2d seen_centroid(const cv::Mat1b& image, const cv::Rect& window) {
  return centroid(window, [&](int u, int v) { return double(image(v, u)); });
}

// By the filter's camera model, which shares no code with the renderer's lens.
Vector2d expected_centroid(const slam::Camera& camera, const cv::Rect& window, const Vector3d& p_C,
                           double radius) {
  return centroid(window, [&](int u, int v) {
    constexpr int parts = 4;
    int covered = 0;
    for (int part = 0; part < parts * parts; ++part) {
      const Vector2d in_pixel((part % parts + 0.5) / parts - 0.5, (part / parts + 0.5) / parts - 0.5);
      const Vector3d ray = camera.unproject(Vector2d(u, v) + in_pixel)->h.normalized();
      covered += ray.cross(p_C).norm() < radius;
    }
    return double(covered);
  });
}

void fly_to(mjData& data, const Vector3d& p, const Eigen::Quaterniond& q) {
  Eigen::Map<Vector3d>(data.qpos) = p;
  Eigen::Map<Eigen::Vector4d>(data.qpos + 3) << q.w(), q.x(), q.y(), q.z();
}

Eigen::Isometry3d pose_of_camera(const Vector3d& p, const Eigen::Quaterniond& q) {
  Eigen::Matrix3d R_HC;  // optical axes in the head's: x right = -y, y down = -z, z ahead = x
  R_HC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Eigen::Translation3d(p) * q * Eigen::Isometry3d(Eigen::AngleAxisd(R_HC));
}

}  // namespace

// Each ball's error is averaged over poses that shift the image by parts of a pixel: the steps of its edge
// cancel, an error of the lens, of the half pixel or of the pose would not.
TEST(HeadCamera, ShowsKnownPointsWithinATenthOfAPixelOverTheWholeImage) {
  constexpr int poses = 6;
  const Vector3d p(0.3, -0.2, 1.4);
  const Eigen::Quaterniond q(Eigen::AngleAxisd(0.7, Vector3d(0.1, -0.2, 0.9).normalized()));
  for (double distortion : {1, 0})
    for (int width : {320, 640}) {
      CameraOptions options;
      options.width_px = width, options.height_px = width * 3 / 4, options.distortion = distortion;
      const CameraModel model = camera_model(options);
      const slam::Camera filter_camera({model.width_px, model.height_px, model.fu_px, model.fv_px,
                                        model.u0_px, model.v0_px, slam::OneParameterRadial{model.k1_px2}});
      const std::vector<Ball> balls = balls_in_view(model, pose_of_camera(p, q));
      std::string room;
      for (const Ball& ball : balls) room += white_ball(ball);
      HeadCamera camera(head_in(room), options);
      const Data plant = data_at_rest(camera.model());
      std::vector<Vector2d> error(balls.size(), Vector2d::Zero());
      for (int pose = 0; pose < poses; ++pose) {
        // rad: a third of a pixel and less from pose to pose
        const Vector3d turn(0, 0.0017 * pose, 0.0011 * pose);
        const Eigen::Quaterniond q_pose =
            q * Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()));
        fly_to(*plant, p, q_pose);
        const cv::Mat1b image = camera.render(*plant);
        for (std::size_t i = 0; i < balls.size(); ++i) {
          const Vector3d p_C = pose_of_camera(p, q_pose).inverse() * balls[i].p_W;
          const Vector2d uv = model.project(p_C);
          const cv::Rect window = cv::Rect(int(uv.x()) - 13, int(uv.y()) - 13, 27, 27) &
                                  cv::Rect(0, 0, model.width_px, model.height_px);
          error[i] += (seen_centroid(image, window) -
                       expected_centroid(filter_camera, window, p_C, balls[i].radius)) /
                      poses;
        }
      }
      for (const Vector2d& e : error) EXPECT_LT(e.norm(), 0.1) << width;
      const Vector2d mean =
          std::accumulate(error.begin(), error.end(), Vector2d(0, 0)) / double(error.size());
      EXPECT_LT(mean.norm(), 0.02);  // half a pixel forgotten anywhere would show here first
    }
}

TEST(HeadCamera, DoesNotSeeTheHeadItSitsIn) {
  HeadCamera camera(head_in("<geom type='sphere' size='1' pos='0 0 -50'/>"), CameraOptions{});
  EXPECT_EQ(cv::countNonZero(camera.render(*data_at_rest(camera.model()))), 0);
}

TEST(HeadCamera, TwoCamerasGiveTheSameBytes) {
  HeadCamera first(load_model("hrp2", "office", models()), CameraOptions{}),
      second(load_model("hrp2", "office", models()), CameraOptions{});
  const Data plant = data_at_rest(first.model());
  plant->qpos[2] = 0.65;
  const cv::Mat image = first.render(*plant);
  EXPECT_EQ(cv::norm(image, second.render(*plant), cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(image, first.render(*plant), cv::NORM_INF), 0);
}

// The lamps go off in the middle of the frame: a row has their light for its own part of the exposure.
TEST(HeadCamera, InTheDarkRowsKeepTheGivenShareOfTheirLightAtTheirTime) {
  const auto row_level = [](double exposure_s, double readout_s, int ms, int row) {
    CameraOptions options;
    options.exposure_s = exposure_s, options.readout_s = readout_s, options.subframes = 21;
    HeadCamera camera(
        head_in(
            "<geom type='plane' size='20 20 50' pos='3 0 0' xyaxes='0 -1 0 0 0 1' rgba='0.8 0.8 0.8 1'/>"),
        options);
    RecentMotion motion(Shutter(options).lead());
    motion.add(std::chrono::seconds(0), camera.model(), *data_at_rest(camera.model()));
    return cv::mean(camera.render(motion, std::chrono::milliseconds(ms), {2, 1, 0.25}).row(row))[0];
  };
  for (const auto& [ms, level] : {std::pair(1999, 204), {2000, 51}, {2999, 51}, {3000, 204}})
    EXPECT_NEAR(row_level(0, 0, ms, 120), level, 1) << ms;
  EXPECT_NEAR(row_level(0.02, 0, 2000, 20), (204 + 51) / 2, 8);
  for (const auto& [row, level] : {std::pair(20, 204), {100, 204}, {140, 51}, {220, 51}})
    EXPECT_NEAR(row_level(0, 0.02, 2000, row), level, 1) << row;
}

}  // namespace sim::camera
