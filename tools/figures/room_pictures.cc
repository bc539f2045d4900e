// Draws the pictures of sim/camera/README.md: the robot in its rooms, and the views of its head camera at
// four headings with each effect of shutter, light and noise.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/camera/head_camera.h"
#include "sim/sensor_errors/image_errors.h"
#include "tools/benchmarks/corner_error.h"

namespace {

using namespace sim::camera;
using namespace sim::physics;
using Eigen::Vector3d;

constexpr double kDegree = CV_PI / 180;
const std::filesystem::path kModels = GAITSLAM_MODELS;

void bend(const mjModel& model, mjData& data, const std::string& limb,
          std::initializer_list<double> degrees) {
  int joint = 0;
  for (const double angle : degrees) {
    const std::string name = limb + "_JOINT" + std::to_string(joint++);
    const int id = mj_name2id(&model, mjOBJ_JOINT, name.c_str());
    if (id < 0) throw std::runtime_error("the robot has no joint " + name);
    data.qpos[model.jnt_qposadr[id]] = angle * kDegree;
  }
}

// In the middle of a step on the tangent circle, after turning by `yaw`.
void walk(const mjModel& model, mjData& data, double yaw) {
  stand_on_circle(data, yaw);
  bend(model, data, "RLEG", {0, 0, -26, 50, -24, 0});
  bend(model, data, "LLEG", {0, 0, -38, 70, -32, 0});
  bend(model, data, "RARM", {4, -10, 0, -34, 0, 0});
  bend(model, data, "LARM", {26, 10, 0, -26, 0, 0});
  mj_kinematics(&model, &data);
  mj_camlight(&model, &data);
}

Eigen::Isometry3d looking(const Vector3d& from, const Vector3d& at) {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  Eigen::Matrix3d axes;
  axes.col(2) = (at - from).normalized();
  axes.col(0) = axes.col(2).cross(Vector3d::UnitZ()).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  X_WC.linear() = axes;
  X_WC.translation() = from;
  return X_WC;
}

cv::Mat3b robot_in(const std::string& room, const Vector3d& from, const Vector3d& at) {
  constexpr int width = 1200, height = 750, focal = 640;
  const Model model = load_model("hrp2", room, kModels);
  const Data data(mj_makeData(model.get()));
  walk(*model, *data, 0.5);
  const Pinhole view{2 * width, 2 * height, 2 * focal, -0.5 * width / focal, -0.5 * height / focal, 0, 0, {}};
  Scene scene(*model, {view}, 4, WorldOptions{}.seed, Channels::rgb, Robot::whole);
  cv::Mat picture = scene.draw(*data, looking(from, at));
  cv::resize(picture, picture, {width, height}, 0, 0, cv::INTER_AREA);
  cv::cvtColor(picture, picture, cv::COLOR_RGB2BGR);
  return picture;
}

// At the start of the next second the head turns left at 2 rad/s: what blur and readout need to show.
cv::Mat1b turning_view(HeadCamera& camera, double yaw, const WorldOptions::LightsOff& off = {}) {
  constexpr double kRate = 2;  // rad/s
  const Data data(mj_makeData(&camera.model()));
  RecentMotion motion(2 * camera.lead());
  const std::chrono::milliseconds stamp(1000);
  for (auto t = stamp - camera.lead(); t <= stamp + camera.lead(); t += std::chrono::milliseconds(1)) {
    walk(camera.model(), *data, yaw + kRate * 1e-3 * double((t - stamp).count()));
    motion.add(t, camera.model(), *data);
  }
  return camera.render(motion, stamp, off);
}

// What the error does to a picture that the ideal camera took.
cv::Mat1b with(const sim::sensor_errors::ImageOptions& error, const cv::Mat1b& image) {
  return sim::sensor_errors::ImageErrors(error, 1, {}).apply(image, std::chrono::seconds(1));
}

// One row for each effect, a column for each heading: as drawn; motion blur; rolling shutter; lights off;
// noise.
cv::Mat effects() {
  CameraOptions sharp, blurred, rolling;
  blurred.exposure_s = 0.02, rolling.readout_s = 0.03, blurred.subframes = rolling.subframes = 16;
  const auto four = [](const CameraOptions& options, const auto& view) {
    HeadCamera camera(load_model("hrp2", "office", kModels), options, WorldOptions{}.seed);
    std::vector<cv::Mat> views;
    for (int quarter = 0; quarter < 4; ++quarter) views.push_back(view(camera, quarter * CV_PI / 2));
    cv::Mat row;
    cv::hconcat(views, row);
    return row;
  };
  const auto turning = [](HeadCamera& camera, double yaw) { return turning_view(camera, yaw); };
  const auto dark = [](HeadCamera& camera, double yaw) { return turning_view(camera, yaw, {0, 2, 0.15}); };
  sim::sensor_errors::ImageOptions clean, vignetting, gain, noise;
  clean.read_sigma_grey = clean.shot_sigma_grey = 0;
  vignetting = gain = noise = clean;
  vignetting.vignetting_fraction = 0.6, gain.gain = 1.35, noise.read_sigma_grey = 6,
  noise.shot_sigma_grey = 10;
  const auto with_error = [&](const sim::sensor_errors::ImageOptions& error) {
    return four(sharp,
                [&](HeadCamera& camera, double yaw) { return with(error, turning_view(camera, yaw)); });
  };
  cv::Mat sheet;
  cv::vconcat(
      std::vector<cv::Mat>{four(sharp, turning), four(blurred, turning), four(rolling, turning),
                           four(sharp, dark), with_error(vignetting), with_error(gain), with_error(noise)},
      sheet);
  return sheet;
}

void draw_all(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const auto write = [&](const char* name, const cv::Mat& picture) {
    if (!cv::imwrite((folder / name).string(), picture, {cv::IMWRITE_JPEG_QUALITY, 88}))
      throw std::runtime_error("cannot write " + (folder / name).string());
  };
  write("robot_in_office.jpg", robot_in("office", {3.35, 1.05, 1.75}, {-0.6, -1.0, 0.75}));
  write("robot_in_hall.jpg", robot_in("hall", {4.6, -2.2, 1.9}, {-0.9, 1.2, 0.9}));
  write("head_views_effects.jpg", effects());
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return std::fputs("usage: room_pictures OUT_DIR\n", stderr), 2;
  draw_all(argv[1]);
} catch (const std::exception& error) {
  std::fprintf(stderr, "room_pictures: %s\n", error.what());
  return 2;
}
