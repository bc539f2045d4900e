#include "sim/camera/lidar.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "sim/camera/scene.h"
#include "sim/camera/shapes.h"
#include "walking/kinematics.h"

namespace sim::camera {
namespace {

constexpr double kCyclesPerTurn = 120 * std::numbers::sqrt2;
constexpr float kBoxMargin = 1e-3f;  // m, for rounding in single precision
constexpr std::int64_t kSecond = 1'000'000'000, kMillisecond = 1'000'000;

// Outward normal of a geom at a point on it, in the geom's axes.
Eigen::Vector3d normal_at(const mjModel& model, int geom, const Eigen::Vector3d& p) {
  const Eigen::Vector3d size = Eigen::Map<const Eigen::Vector3d>(model.geom_size + 3 * geom);
  const int type = model.geom_type[geom];
  if (type == mjGEOM_PLANE) return Eigen::Vector3d::UnitZ();
  if (type == mjGEOM_ELLIPSOID) return p.cwiseQuotient(size.cwiseAbs2()).normalized();
  Eigen::Vector3d normal = p;  // sphere
  if (type == mjGEOM_BOX) {
    Eigen::Index axis;
    p.cwiseQuotient(size).cwiseAbs().maxCoeff(&axis);
    normal = std::copysign(1.0, p(axis)) * Eigen::Vector3d::Unit(axis);
  }
  if (type == mjGEOM_CAPSULE) normal.z() -= std::clamp(p.z(), -size.y(), size.y());
  if (type == mjGEOM_CYLINDER) {
    const bool on_end = std::abs(p.z()) - size.y() > p.head<2>().norm() - size.x();
    normal = on_end ? Eigen::Vector3d(0, 0, p.z()) : Eigen::Vector3d(p.x(), p.y(), 0);
  }
  return normal.normalized();
}

std::int64_t first_ray_at(const rig::Lidar& options, std::chrono::nanoseconds t) {
  const std::int64_t per_second = options.points_per_s, rest = t.count() % kSecond;
  return t.count() / kSecond * per_second + (rest * per_second + kSecond - 1) / kSecond;
}

}  // namespace

Eigen::Vector3d ray_direction(const rig::Lidar& options, std::int64_t number) {
  const double turns = double(number) * options.rate_hz / options.points_per_s;
  const double cycle = std::fmod(kCyclesPerTurn * turns, 1.0);
  const double low = std::sin(options.lowest_rad), high = std::sin(options.highest_rad);
  const double z = low + (high - low) * (1 - std::abs(2 * cycle - 1));
  const double azimuth = 2 * std::numbers::pi * std::fmod(turns, 1.0), across = std::sqrt(1 - z * z);
  return {across * std::cos(azimuth), across * std::sin(azimuth), z};
}

std::chrono::nanoseconds ray_time(const rig::Lidar& options, std::int64_t number) {
  const std::int64_t per_second = options.points_per_s;
  return std::chrono::nanoseconds(number / per_second * kSecond + number % per_second * kSecond / per_second);
}

Lidar::Lidar(physics::Model robot_in_room, const physics::Place& place, const rig::Lidar& options,
             std::uint64_t texture_seed)
    : model_(std::move(robot_in_room)),
      data_(data_at_rest(*model_)),
      place_(place),
      options_(options),
      pictures_(std::size_t(model_->ntex)) {
  for (int geom = 0; geom < model_->ngeom; ++geom) {
    if (!is_drawn(*model_, geom) || is_glass(*model_, geom) || model_->geom_bodyid[geom] == place.body)
      continue;
    shapes_.push_back(geom);
    const int texture = texture_of(*model_, geom);
    if (texture < 0 || !pictures_[std::size_t(texture)].empty()) continue;
    cv::Mat gray = texture_picture(*model_, *data_, texture, texture_seed);
    cv::cvtColor(gray, gray, cv::COLOR_RGB2GRAY);
    const cv::Size size(std::max(1, gray.cols / 4), std::max(1, gray.rows / 4));
    cv::resize(gray, pictures_[std::size_t(texture)], size, 0, 0, cv::INTER_AREA);
  }
  const auto count = Eigen::Index(shapes_.size());
  lower_.resize(count, 3), upper_.resize(count, 3), enters_.resize(count), leaves_.resize(count);
  for (Eigen::Index shape = 0; shape < count; ++shape) set_box(shape);
}

void Lidar::set_box(Eigen::Index shape) {
  const int geom = shapes_[std::size_t(shape)];
  const Eigen::AlignedBox3d box = physics::box_around(*model_, *data_, geom);
  lower_.row(shape) = box.min().cast<float>().array() - kBoxMargin;
  upper_.row(shape) = box.max().cast<float>().array() + kBoxMargin;
}

// Computes all poses at that time and returns X_WS.
Eigen::Isometry3d Lidar::pose(const RecentMotion& motion, double t_s) {
  Eigen::Map<Eigen::VectorXd>(data_->qpos, model_->nq) = motion.at(t_s, *model_);
  data_->time = t_s;
  physics::pose_bodies(*model_, *data_);
  return physics::pose_in(data_->xpos + 3 * place_.body, data_->xmat + 9 * place_.body) * place_.X_BL;
}

// Only shapes whose bounding box the ray enters are tested.
Lidar::Hit Lidar::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& along) {
  const Eigen::Array3f o = origin.cast<float>();
  const Eigen::Array3f slow = along.cwiseAbs().cwiseMax(1e-9).cast<float>().array().inverse();
  const auto far = [&](int axis) -> const auto& { return along(axis) > 0 ? upper_ : lower_; };
  const auto near = [&](int axis) -> const auto& { return along(axis) > 0 ? lower_ : upper_; };
  const Eigen::Array3f inverse = (along.array() > 0).select(slow, -slow);
  const auto distance = [&](const auto& corners, int axis) {
    return (corners.col(axis) - o(axis)) * inverse(axis);
  };
  enters_ = distance(near(0), 0).max(distance(near(1), 1)).max(distance(near(2), 2)).max(0.0f);
  leaves_ = distance(far(0), 0).min(distance(far(1), 1)).min(distance(far(2), 2));
  Hit first{-1, options_.furthest_m};
  for (Eigen::Index shape = 0; shape < enters_.size(); ++shape) {
    if (enters_[shape] > leaves_[shape] || enters_[shape] > first.distance) continue;
    const int geom = shapes_[std::size_t(shape)];
    const double found = physics::ray_distance(*model_, *data_, geom, origin, along);
    if (found >= 0 && found < first.distance) first = {geom, found};
  }
  return first;
}

double Lidar::intensity(int geom, const Eigen::Vector3d& point, const Eigen::Vector3d& along) const {
  const Eigen::Isometry3d X_WG = geom_pose(*data_, geom);
  const Eigen::Vector3d p_G = X_WG.inverse() * point;
  double gray = double(paint_of(*model_, geom).rgb.dot(Eigen::Vector3f(0.299f, 0.587f, 0.114f)));
  if (const int texture = texture_of(*model_, geom); texture >= 0) {
    const cv::Mat1b& picture = pictures_[std::size_t(texture)];
    const Eigen::Vector2f uv = picture_point(*model_, geom, p_G.cast<float>());
    const auto texel = [](float part, int count) {  // pictures repeat
      return std::clamp(int((part - std::floor(part)) * float(count)), 0, count - 1);
    };
    gray *= picture(texel(uv.y(), picture.rows), texel(uv.x(), picture.cols)) / 255.0;
  }
  if (const int type = model_->geom_type[geom]; type == mjGEOM_MESH || type == mjGEOM_HFIELD)
    return gray;  // as if it faced the lidar
  return gray * std::abs(along.dot(X_WG.linear() * normal_at(*model_, geom, p_G)));
}

std::vector<slam::LidarPoint> Lidar::scan(const RecentMotion& motion, std::chrono::nanoseconds begin,
                                          std::chrono::nanoseconds end) {
  std::vector<slam::LidarPoint> points;
  std::int64_t number = first_ray_at(options_, begin);
  const std::int64_t last = first_ray_at(options_, end);
  std::int64_t millisecond = begin.count() / kMillisecond;
  Eigen::Isometry3d X_WS_after = pose(motion, 1e-3 * double(millisecond));
  for (; number < last; ++millisecond) {
    const Eigen::Isometry3d X_WS_before = X_WS_after;
    X_WS_after = pose(motion, 1e-3 * double(millisecond + 1));
    pose(motion, 1e-3 * (double(millisecond) + 0.5));
    for (Eigen::Index shape = 0; shape < Eigen::Index(shapes_.size()); ++shape)
      if (moves(*model_, shapes_[std::size_t(shape)])) set_box(shape);
    for (; number < last; ++number) {
      const std::int64_t t = ray_time(options_, number).count(), since = t - millisecond * kMillisecond;
      if (since >= kMillisecond) break;
      const Eigen::Isometry3d X_WS =
          walking::pose_between(X_WS_before, X_WS_after, double(since) / kMillisecond);
      const Eigen::Vector3d along_S = ray_direction(options_, number), along = X_WS.linear() * along_S;
      const Hit hit = cast(X_WS.translation(), along);
      if (hit.geom < 0 || hit.distance < options_.nearest_m || !returns_light(*model_, hit.geom)) continue;
      const Eigen::Vector3f p_S = (hit.distance * along_S).cast<float>();
      const double light = intensity(hit.geom, X_WS.translation() + hit.distance * along, along);
      points.push_back({p_S.x(), p_S.y(), p_S.z(), float(light), std::int32_t(t - begin.count())});
    }
  }
  return points;
}

}  // namespace sim::camera
