#include "sim/camera/head_camera.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <string>

#include "slam/camera.h"

namespace sim::camera {
using namespace physics;
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

const std::filesystem::path kModels = std::filesystem::path(GAITSLAM_SOURCE_DIR) / "models";

// A robot that is nothing but a flying head camera, and a room of the given geoms.
class Models {
 public:
  explicit Models(const std::string& room) {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "head.xml")
        << "<mujoco><worldbody><body name='head'><freejoint/>"
           "<geom type='sphere' size='0.01' group='2'/>"
           "<camera name='head_camera' xyaxes='0 -1 0 0 0 1'/></body></worldbody></mujoco>";
    std::ofstream(folder_ / "room.xml")
        << "<mujoco><visual><headlight ambient='1 1 1' diffuse='0 0 0' specular='0 0 0'/></visual><worldbody>"
        << room << "</worldbody></mujoco>";
  }
  ~Models() { std::filesystem::remove_all(folder_); }
  Model load() const { return load_model("head", "room", folder_); }

 private:
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("gaitslam_head_camera_" + std::to_string(getpid()));
};

struct Ball {
  Vector3d p_W;
  double radius;
};

std::string white_ball(const Ball& ball) {
  char text[300];
  std::snprintf(text, sizeof text,
                "<geom type='sphere' size='%.17g' pos='%.17g %.17g %.17g' rgba='1 1 1 1'/>", ball.radius,
                ball.p_W.x(), ball.p_W.y(), ball.p_W.z());
  return text;
}

// Balls that cover the image, borders included, at depths from 0.6 to 6 m, each about 7 px in radius.
std::vector<Ball> balls_in_view(const CameraModel& camera, const Eigen::Isometry3d& X_WC) {
  std::vector<Ball> balls;
  for (int row = 0; row < 5; ++row)
    for (int column = 0; column < 7; ++column) {
      const Vector2d uv(camera.width_px * (column + 0.5) / 7, camera.height_px * (row + 0.5) / 5);
      const double depth = 0.6 * std::pow(10.0, ((row * 7 + column) * 5 % 35) / 34.0);
      const Vector3d ray = camera.direction(uv).homogeneous();
      balls.push_back({X_WC * (depth * ray), depth * 7 / camera.fu_px});
    }
  return balls;
}

// The filter's camera model, which shares no code with the renderer's lens.
slam::Camera filter_camera(const CameraModel& camera) {
  return slam::Camera({.width_px = camera.width_px,
                       .height_px = camera.height_px,
                       .fu_px = camera.fu_px,
                       .fv_px = camera.fv_px,
                       .u0_px = camera.u0_px,
                       .v0_px = camera.v0_px,
                       .lens = slam::OneParameterRadial{camera.k1_px2}});
}

bool hits(const Vector3d& direction, const Vector3d& center, double radius) {
  return direction.cross(center).squaredNorm() < radius * radius * direction.squaredNorm();
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

Vector2d expected_centroid(const slam::Camera& camera, const cv::Rect& window, const Vector3d& p_C,
                           double radius) {
  return centroid(window, [&](int u, int v) {
    constexpr int parts = 4;
    int covered = 0;
    for (int row = 0; row < parts; ++row)
      for (int column = 0; column < parts; ++column) {
        const Vector2d uv(u + (column + 0.5) / parts - 0.5, v + (row + 0.5) / parts - 0.5);
        covered += hits(camera.unproject(uv)->h, p_C, radius);
      }
    return double(covered);
  });
}

cv::Rect window_around(const CameraModel& camera, const Vector3d& p_C) {
  const Vector2d uv = camera.project(p_C);
  return cv::Rect(int(uv.x()) - 13, int(uv.y()) - 13, 27, 27) &
         cv::Rect(0, 0, camera.width_px, camera.height_px);
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
  for (Lens lens : {Lens::wide, Lens::pinhole})
    for (auto [width, samples] :
         {std::pair(320, 0), std::pair(320, 4), std::pair(640, 0), std::pair(640, 4)}) {
      CameraOptions options;
      options.width_px = width, options.height_px = width * 3 / 4, options.lens = lens,
      options.samples = samples;
      const CameraModel model = camera_model(options);
      const std::vector<Ball> balls = balls_in_view(model, pose_of_camera(p, q));
      std::string room;
      for (const Ball& ball : balls) room += white_ball(ball);
      HeadCamera camera(Models(room).load(), options);
      const Data plant(mj_makeData(&camera.model()));
      std::vector<Vector2d> error(balls.size(), Vector2d::Zero());
      for (int pose = 0; pose < poses; ++pose) {
        const Vector3d turn(0, 0.0017 * pose,
                            0.0011 * pose);  // rad: a third of a pixel and less from pose to pose
        const Eigen::Quaterniond q_pose =
            q * Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()));
        fly_to(*plant, p, q_pose);
        const cv::Mat1b image = camera.render(*plant);
        for (std::size_t i = 0; i < balls.size(); ++i) {
          const Vector3d p_C = pose_of_camera(p, q_pose).inverse() * balls[i].p_W;
          const cv::Rect window = window_around(model, p_C);
          const Vector2d seen = centroid(window, [&](int u, int v) { return double(image(v, u)); });
          error[i] += (seen - expected_centroid(filter_camera(model), window, p_C, balls[i].radius)) / poses;
        }
      }
      for (const Vector2d& e : error) EXPECT_LT(e.norm(), 0.1) << width << " " << samples;
      const Vector2d mean =
          std::accumulate(error.begin(), error.end(), Vector2d(0, 0)) / double(error.size());
      EXPECT_LT(mean.norm(), 0.02);  // half a pixel forgotten anywhere would show here first
    }
}

TEST(HeadCamera, EachFrameBelongsToThePoseItWasAskedFor) {
  HeadCamera camera(Models(white_ball({{3, 0, 0}, 0.1})).load(), CameraOptions{});
  const Data plant(mj_makeData(&camera.model()));
  const cv::Rect whole(0, 0, 320, 240);
  for (double y : {-0.8, 0.7, 0.0}) {
    fly_to(*plant, {0, y, 0}, Eigen::Quaterniond::Identity());
    const cv::Mat1b image = camera.render(*plant);
    const Vector2d seen = centroid(whole, [&](int u, int v) { return double(image(v, u)); });
    EXPECT_NEAR(seen.x(), camera.camera().project({y, 0, 3}).x(),
                0.2);  // the ball's outline is not quite centerd
  }
}

TEST(HeadCamera, DoesNotSeeTheHeadItSitsIn) {
  HeadCamera camera(Models("<geom type='sphere' size='1' pos='0 0 -50'/>").load(), CameraOptions{});
  const Data plant(mj_makeData(&camera.model()));
  fly_to(*plant, {0, 0, 0}, Eigen::Quaterniond::Identity());
  EXPECT_EQ(cv::countNonZero(camera.render(*plant)), 0);
}

TEST(HeadCamera, TwoCamerasGiveTheSameBytes) {
  CameraOptions options;
  HeadCamera first(load_model("hrp2", "office", kModels), options),
      second(load_model("hrp2", "office", kModels), options);
  const Data plant(mj_makeData(&first.model()));
  plant->qpos[2] = 0.65;
  const cv::Mat image = first.render(*plant);
  EXPECT_EQ(cv::norm(image, second.render(*plant), cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(image, first.render(*plant), cv::NORM_INF), 0);
}

TEST(HeadCamera, BrightnessOfASurfaceDoesNotDependOnWhereTheHeadIs) {
  const std::string wall =
      "<light directional='true' dir='1 0.4 -0.5' diffuse='0.5 0.5 0.5' specular='0 0 0'/>"
      "<geom type='plane' size='20 20 50' pos='3 0 0' xyaxes='0 -1 0 0 0 1' rgba='0.4 0.4 0.4 1'/>";
  HeadCamera camera(Models(wall).load(), CameraOptions{});
  const Data plant(mj_makeData(&camera.model()));
  double level = -1;
  for (double x : {0.0, 1.0, 2.0}) {
    fly_to(*plant, {x, x / 3, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(0.3 * x, Vector3d::UnitZ())));
    double lowest, highest;
    cv::minMaxLoc(camera.render(*plant), &lowest, &highest);
    if (level < 0) level = lowest;
    EXPECT_EQ(lowest, level);
    EXPECT_EQ(highest, level);
  }
}

// A ball in the middle of the image, the camera turning left at 2 rad/s: 0.394 px a millisecond.
TEST(HeadCamera, AFrameOfATurningCameraIsBlurredAlongTheTurnOrSlantedByTheReadout) {
  const Models models(white_ball({{3, 0, 0.0}, 0.05}) + white_ball({{3, 0, 0.7}, 0.05}) +
                      white_ball({{3, 0, -0.7}, 0.05}));
  constexpr double kRate = 2;
  const auto seen = [&](double exposure, double readout) {
    CameraOptions options;
    options.exposure_s = exposure, options.readout_s = readout, options.subframes = 12;
    HeadCamera camera(models.load(), options);
    const Data plant(mj_makeData(&camera.model()));
    RecentMotion motion(2 * camera.lead());
    for (int ms = 80; ms <= 120; ++ms) {
      fly_to(*plant, {0, 0, 0},
             Eigen::Quaterniond(Eigen::AngleAxisd(kRate * (ms - 100) * 1e-3, Vector3d::UnitZ())));
      motion.add(std::chrono::milliseconds(ms), camera.model(), *plant);
      if (ms == 100 + camera.lead().count()) break;
    }
    return cv::Mat1b(camera.render(motion, std::chrono::milliseconds(100), {}));
  };
  const auto middle = [](const cv::Mat1b& image, const cv::Rect& window) {
    return centroid(window, [&](int u, int v) { return double(image(v, u)); });
  };
  const auto wide = [](const cv::Mat1b& image) {  // pixels in the middle ball's row that are not dark
    return cv::countNonZero(image(cv::Rect(120, 127, 80, 1)) > 25);
  };
  const cv::Rect upper(120, 60, 80, 40), center(120, 107, 80, 40), lower(120, 154, 80, 40);
  const cv::Mat1b sharp = seen(0, 0), blurred = seen(0.02, 0), rolling = seen(0, 0.02);
  EXPECT_NEAR(middle(blurred, center).x(), middle(sharp, center).x(), 0.1);  // the stamp is mid-exposure
  EXPECT_NEAR(wide(blurred) - wide(sharp), 197 * kRate * 0.02, 2.5);         // 7.9 px further, cut at a tenth
  // Turning left moves the image right; a row 1/240 of the readout later sees it further right.
  const double rows = middle(sharp, lower).y() - middle(sharp, upper).y();
  const double slant = middle(rolling, lower).x() - middle(rolling, upper).x();
  const double turn_px = 197 * kRate * 0.02 * rows / 240;
  EXPECT_NEAR(slant - (middle(sharp, lower).x() - middle(sharp, upper).x()), turn_px, 0.08 * turn_px);
}

TEST(HeadCamera, InTheDarkSurfacesKeepTheGivenShareOfTheirLight) {
  HeadCamera camera(
      Models("<geom type='plane' size='20 20 50' pos='3 0 0' xyaxes='0 -1 0 0 0 1' rgba='0.8 0.8 0.8 1'/>")
          .load(),
      CameraOptions{});
  const Data plant(mj_makeData(&camera.model()));
  RecentMotion motion(camera.lead());
  fly_to(*plant, {0, 0, 0}, Eigen::Quaterniond::Identity());
  motion.add(std::chrono::seconds(0), camera.model(), *plant);
  const auto level = [&](double t) {
    return cv::mean(camera.render(motion, std::chrono::milliseconds(std::llround(1e3 * t)), {2, 1, 0.25}))[0];
  };
  EXPECT_EQ(level(1.999), 204);
  EXPECT_NEAR(level(2), 51, 1);
  EXPECT_NEAR(level(2.999), 51, 1);
  EXPECT_EQ(level(3), 204);
}

TEST(HeadCamera, AModelWithoutOneIsRefused) {
  EXPECT_THROW(camera_pose(*Models("").load(), *Data(mj_makeData(Models("").load().get())), "other"),
               std::invalid_argument);
}

}  // namespace sim::camera
