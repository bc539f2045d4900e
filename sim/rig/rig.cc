#include "sim/rig/rig.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "slam/camera.h"

namespace sim::rig {
namespace {

constexpr double kPhysics_hz = 1000;  // positions are known at each millisecond

std::optional<std::string> range_problem(double nearest_m, double furthest_m) {
  if (nearest_m < furthest_m) return std::nullopt;
  return fmt::format("nearest_m {} is not below furthest_m {}", nearest_m, furthest_m);
}

void copy_values(const auto& item, RigSensor& s) {
  if constexpr (requires { item.time_offset_s; }) s.time_offset_s = item.time_offset_s;
  if constexpr (requires { item.rate_hz; }) s.rate_hz = item.rate_hz;
  if constexpr (requires { item.readout_s; }) s.readout_s = item.readout_s;
  if constexpr (requires { item.read_sigma_gray; })
    s.read_sigma_gray = item.read_sigma_gray, s.shot_sigma_gray = item.shot_sigma_gray;
  if constexpr (requires { item.nearest_m; }) s.nearest_m = item.nearest_m, s.furthest_m = item.furthest_m;
  if constexpr (requires { item.aligned_with; })
    s.aligned_with = item.aligned_with, s.baseline_m = item.baseline_m, s.edge_px = item.edge_px,
    s.disparity_sigma_px = item.disparity_sigma_px, s.window_px = item.window_px;
  if constexpr (requires { item.range_sigma_m; })
    s.lowest_rad = item.lowest_rad, s.highest_rad = item.highest_rad, s.range_sigma_m = item.range_sigma_m,
    s.angle_sigma_rad = item.angle_sigma_rad;
  if constexpr (requires { item.gyro_sigma_rad_s; })
    s.gyro_sigma_rad_s = item.gyro_sigma_rad_s, s.gyro_bias_sigma_rad_s = item.gyro_bias_sigma_rad_s,
    s.accelerometer_sigma_m_s2 = item.accelerometer_sigma_m_s2,
    s.accelerometer_bias_sigma_m_s2 = item.accelerometer_bias_sigma_m_s2;
}

bool is_folder_name(std::string_view name) {
  const auto is_plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  return !name.empty() && name.size() <= 40 && std::ranges::all_of(name, is_plain);
}

bool has_images(const Item& item) {
  return std::holds_alternative<GrayEye>(item) || std::holds_alternative<ColorCamera>(item);
}

// Intel RealSense D435i. The color imager, with a rolling shutter, is 15 mm from the left infrared imager,
// which is the head camera. The IMU is a BMI055. Depth is matched at 848 x 480 and decimated to the head
// camera's size.
std::vector<Item> d435i() {
  ColorCamera color;
  color.position_m = {0, 0.015, 0};
  color.rate_hz = 15;
  color.readout_s = 0.016;
  color.subframes = 3;
  DepthCamera depth;
  depth.stereo_width_px = 848;
  Imu imu;
  imu.position_m = {0, -0.005, -0.012};
  imu.gyro_sigma_rad_s = 1e-3;
  imu.accelerometer_sigma_m_s2 = 2e-2;
  return {GrayEye(), color, depth, imu};
}

// The same with a color imager of 848 x 480. The other cameras keep the head camera's size.
std::vector<Item> d435i_848() {
  std::vector<Item> items = d435i();
  auto& color = std::get<ColorCamera>(items[1]);
  color.width_px = 848, color.height_px = 480;
  return items;
}

// Livox Mid-360 above the head.
std::vector<Item> d435i_mid360() {
  std::vector<Item> items = d435i();
  Lidar lidar;
  lidar.position_m = {-0.05, 0, 0.15};
  items.push_back(lidar);
  return items;
}

struct Preset {
  std::string_view name;
  std::vector<Item> (*items)();
};
constexpr Preset kPresets[]{{"head_2006", [] { return std::vector<Item>(); }},
                            {"d435i", d435i},
                            {"d435i_848", d435i_848},
                            {"d435i_mid360", d435i_mid360}};

using Vector6d = Eigen::Matrix<double, 6, 1>;  // fu, fv, k1 to k4
constexpr int kGrid = 40;                      // pixels per side for comparing the two cameras

// A pixel, and the given camera's line of sight (x, y, 1) there.
struct Sightline {
  Eigen::Vector2d pixel, n;
};

// One Gauss-Newton step: the pixel is (u0, v0) + (fu x, fv y)/r (θ + k1 θ³ + ...), linear in each parameter.
Vector6d step(const std::vector<Sightline>& sights, const slam::CameraIntrinsics& camera, const Vector6d& p) {
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
  Vector6d b = Vector6d::Zero();
  for (const Sightline& sight : sights) {
    const double r = sight.n.norm();
    if (r < 1e-9) continue;
    const double angle = std::atan(r), a2 = angle * angle;
    const Eigen::Vector4d powers = angle * Eigen::Vector4d(a2, a2 * a2, a2 * a2 * a2, a2 * a2 * a2 * a2);
    const double bent = angle + powers.dot(p.tail<4>());
    for (int axis = 0; axis < 2; ++axis) {
      const double along = sight.n(axis) / r;
      Vector6d J = Vector6d::Zero();
      J(axis) = along * bent;
      J.tail<4>() = p(axis) * along * powers;
      const double center = axis == 0 ? camera.u0_px : camera.v0_px;
      A += J * J.transpose();
      b += J * (sight.pixel(axis) - center - p(axis) * along * bent);
    }
  }
  return A.ldlt().solve(b);
}

}  // namespace

Eigen::Isometry3d pose(const Mount& mount) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = mount.position_m;
  X.linear() = (Eigen::AngleAxisd(mount.yaw_rad, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(mount.tilt_rad, Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(mount.roll_rad, Eigen::Vector3d::UnitX()))
                   .matrix();
  return X;
}

std::optional<std::string> GrayEye::problem() const {
  if (baseline_m != 0 || !position_m.isZero()) return std::nullopt;
  return "baseline_m is 0: it would be the head camera again";
}

std::optional<std::string> DepthCamera::problem() const { return range_problem(nearest_m, furthest_m); }

std::optional<std::string> Lidar::problem() const {
  if (lowest_rad >= highest_rad) return "lowest_deg is not below highest_deg";
  if (points_per_s < rate_hz) return "points_per_s is below rate_hz: sweeps would be empty";
  return range_problem(nearest_m, furthest_m);
}

std::optional<std::string> Imu::problem() const {
  const double period = kPhysics_hz / rate_hz;
  if (std::abs(period - std::round(period)) < 1e-9) return std::nullopt;
  return fmt::format("rate_hz {} does not divide the physics' {} steps per second", rate_hz, kPhysics_hz);
}

const std::string& name_of(const Item& item) {
  return std::visit([](const auto& sensor) -> const std::string& { return sensor.name; }, item);
}

std::optional<std::vector<Item>> preset(std::string_view name) {
  for (const Preset& one : kPresets)
    if (one.name == name) return one.items();
  return std::nullopt;
}

std::vector<std::string_view> preset_names() {
  std::vector<std::string_view> names;
  for (const Preset& one : kPresets) names.push_back(one.name);
  return names;
}

std::optional<Problem> name_problem(const std::vector<std::string>& names) {
  std::set<std::string> taken{kHeadCamera, kChestImu,   "plan0",   "legs0",
                              "command0",  "encoders0", "forces0", "state_groundtruth_estimate0"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!is_folder_name(names[i]))
      return Problem{i, fmt::format("name '{}': expected 1 to 40 characters of a-z, 0-9 and _", names[i])};
    if (!taken.insert(names[i]).second) return Problem{i, fmt::format("name '{}' is taken", names[i])};
  }
  return std::nullopt;
}

std::optional<Problem> problem(const std::vector<Item>& items) {
  std::vector<std::string> names, cameras{kHeadCamera};
  for (const Item& item : items) {
    names.push_back(name_of(item));
    if (has_images(item)) cameras.push_back(names.back());
  }
  if (const auto found = name_problem(names)) return found;
  std::set<std::string> with_depth;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const auto* depth = std::get_if<DepthCamera>(&items[i]);
    if (!depth) continue;
    if (std::ranges::find(cameras, depth->aligned_with) == cameras.end())
      return Problem{i, fmt::format("aligned_with '{}' is not a camera, expected one of {}",
                                    depth->aligned_with, fmt::join(cameras, ", "))};
    if (!with_depth.insert(depth->aligned_with).second)
      return Problem{i, fmt::format("camera '{}' already has another depth camera", depth->aligned_with)};
  }
  return std::nullopt;
}

Eigen::Isometry3d camera_from_forward_left_up() {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return X;
}

slam::CameraIntrinsics lens(int width_px, int height_px, double fov_rad, double distortion) {
  const double f = width_px / 2.0 / std::tan(fov_rad / 2), s = width_px / 320.0;
  const slam::OneParameterRadial radial{7.37e-6 * distortion / (s * s)};
  return {width_px, height_px, f, f, (width_px - 1) / 2.0, (height_px - 1) / 2.0, radial};
}

std::vector<double> coefficients(const slam::Lens& lens) {
  if (const auto* k = std::get_if<slam::Equidistant>(&lens)) return {k->k1, k->k2, k->k3, k->k4};
  if (const auto* k = std::get_if<slam::RadialTangential>(&lens)) return {k->k1, k->k2, k->p1, k->p2};
  return {std::get<slam::OneParameterRadial>(lens).k1_px2};
}

int partner(const std::vector<RigSensor>& rig, const RigSensor& depth) {
  const auto found = std::ranges::find(rig, depth.aligned_with, &RigSensor::name);
  return found == rig.end() ? -1 : int(found - rig.begin());
}

std::vector<RigSensor> calibrated(const std::vector<Item>& items, const slam::CameraIntrinsics& head,
                                  double head_rate_hz, double head_readout_s,
                                  const std::vector<Eigen::Isometry3d>& X_CL) {
  if (const auto found = problem(items)) throw std::invalid_argument("rig: " + found->what);
  const Eigen::Isometry3d X_LS = camera_from_forward_left_up().inverse();  // optical axes of a camera
  std::vector<RigSensor> sensors;
  for (std::size_t i = 0; i < items.size(); ++i) {
    RigSensor s;
    s.name = name_of(items[i]), s.kind = static_cast<Kind>(items[i].index());
    if (s.kind != Kind::depth) s.X_CS = X_CL[i];
    if (is_camera(s)) s.camera = head, s.rate_hz = head_rate_hz;  // unless the sensor has its own
    if (const auto* eye = std::get_if<GrayEye>(&items[i]))
      s.X_CS = s.X_CS * Eigen::Translation3d(0, -eye->baseline_m, 0) * X_LS, s.readout_s = head_readout_s;
    if (const auto* color = std::get_if<ColorCamera>(&items[i]))
      s.X_CS = s.X_CS * X_LS,
      s.camera = lens(color->width_px, color->height_px, color->fov_rad, color->distortion);
    std::visit([&s](const auto& item) { copy_values(item, s); }, items[i]);
    sensors.push_back(s);
  }
  for (std::size_t i = 0; i < items.size(); ++i) {  // now that all cameras are known
    const auto* depth = std::get_if<DepthCamera>(&items[i]);
    if (!depth) continue;
    RigSensor& s = sensors[i];
    if (const int with = partner(sensors, s); with >= 0) {
      const RigSensor& camera = sensors[std::size_t(with)];
      s.X_CS = camera.X_CS, s.camera = camera.camera;
      s.rate_hz = camera.rate_hz, s.time_offset_s = camera.time_offset_s;
    }
    const double decimation =
        depth->stereo_width_px > 0 ? 1.0 * s.camera.width_px / depth->stereo_width_px : 1;
    s.disparity_sigma_px *= decimation;
    s.window_px = std::max(1.0, s.window_px * decimation);
  }
  return sensors;
}

FittedCamera fit_equidistant(const slam::CameraIntrinsics& camera) {
  const slam::Camera original(camera);
  std::vector<Sightline> grid;
  for (int row = 0; row < kGrid; ++row)
    for (int column = 0; column < kGrid; ++column) {
      const Eigen::Vector2d pixel((camera.width_px - 1.0) * column / (kGrid - 1),
                                  (camera.height_px - 1.0) * row / (kGrid - 1));
      if (const auto ray = original.unproject(pixel)) grid.push_back({pixel, ray->h.head<2>()});
    }
  Vector6d p;
  p << camera.fu_px, camera.fv_px, 0, 0, 0, 0;
  for (int i = 0; i < 20; ++i) p += step(grid, camera, p);
  FittedCamera fitted{camera};
  fitted.camera.fu_px = p(0), fitted.camera.fv_px = p(1);
  fitted.camera.lens = slam::Equidistant{p(2), p(3), p(4), p(5)};
  const slam::Camera equidistant(fitted.camera);
  for (const Sightline& sight : grid) {
    const auto at = equidistant.project(sight.n.homogeneous());
    if (!at) throw std::logic_error("the fitted lens covers less than the original one");
    const double off = (at->pixel - sight.pixel).norm();
    fitted.rms_px += off * off / double(grid.size());
    fitted.largest_px = std::max(fitted.largest_px, off);
  }
  fitted.rms_px = std::sqrt(fitted.rms_px);
  return fitted;
}

}  // namespace sim::rig
