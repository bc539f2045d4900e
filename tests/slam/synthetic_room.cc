#include "tests/slam/synthetic_room.h"

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace slam::synthetic {
namespace {

constexpr double kTexel = 0.01;  // m
constexpr int kLevels = 5;

/// Smooth noise of several wavelengths with printed rectangles and discs on it.
cv::Mat print(int rows, int columns, std::mt19937_64& random) {
  cv::Mat image(rows, columns, CV_32F, cv::Scalar(120));
  const auto below = [&random](int n) { return static_cast<int>(random() % static_cast<std::uint64_t>(n)); };
  for (int cell : {64, 24, 10}) {
    cv::Mat coarse(rows / cell + 3, columns / cell + 3, CV_32F), fine;
    for (int i = 0; i < coarse.rows * coarse.cols; ++i)
      coarse.ptr<float>()[i] = static_cast<float>(below(51)) - 25;
    cv::resize(coarse, fine, cv::Size(columns, rows), 0, 0, cv::INTER_CUBIC);
    image += fine;
  }
  for (int i = 0; i < rows * columns / 1800; ++i) {
    const cv::Point at(below(columns), below(rows));
    const cv::Scalar gray(30 + below(196));
    if (below(3) == 0)
      cv::circle(image, at, 3 + below(12), gray, cv::FILLED, cv::LINE_8);
    else
      cv::rectangle(image, at, at + cv::Point(4 + below(36), 4 + below(36)), gray, cv::FILLED, cv::LINE_8);
  }
  cv::Mat bytes;
  image.convertTo(bytes, CV_8U);
  return bytes;
}

std::vector<cv::Mat> pyramid(const cv::Mat& image) {
  std::vector<cv::Mat> levels{image};
  for (int i = 1; i < kLevels; ++i) {
    const cv::Size half((levels.back().cols + 1) / 2, (levels.back().rows + 1) / 2);
    cv::Mat next;
    cv::resize(levels.back(), next, half, 0, 0, cv::INTER_AREA);
    levels.push_back(next);
  }
  return levels;
}

float bilinear(const cv::Mat& image, float u, float v) {
  u = std::clamp(u, 0.0F, static_cast<float>(image.cols) - 1.001F);
  v = std::clamp(v, 0.0F, static_cast<float>(image.rows) - 1.001F);
  const int column = static_cast<int>(u), row = static_cast<int>(v);
  const float a = u - static_cast<float>(column), b = v - static_cast<float>(row);
  const uchar* up = image.ptr<uchar>(row) + column;
  const uchar* down = image.ptr<uchar>(std::min(row + 1, image.rows - 1)) + column;
  const int next = image.cols > 1 ? 1 : 0;
  return (1 - b) * ((1 - a) * up[0] + a * up[next]) + b * ((1 - a) * down[0] + a * down[next]);
}

Eigen::Matrix3d heading(double yaw) {
  Eigen::Matrix3d R_BC;  // camera: z ahead, x right, y down
  R_BC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * R_BC;
}

}  // namespace

double Normal::operator()() {
  const double u = (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53;
  const double v = (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

Room::Room() : walls_{{-3.4F, -4.8F, 0}, {3.6F, 6.2F, 3}} {
  furniture_ = {{{2.6F, -1.0F, 0}, {3.6F, 0.6F, 0.9F}},   {{2.9F, 2.4F, 0}, {3.6F, 4.0F, 2.0F}},
                {{-3.4F, -2.0F, 0}, {-2.6F, 0.0F, 1.9F}}, {{-3.4F, 2.0F, 0}, {-2.2F, 3.4F, 0.8F}},
                {{-1.0F, 4.9F, 0}, {0.6F, 6.2F, 1.2F}},   {{0.4F, -4.8F, 0}, {1.8F, -3.6F, 1.5F}},
                {{-1.8F, -3.4F, 0}, {-0.9F, -2.6F, 1.0F}}};
  std::mt19937_64 random(20060901);
  const auto add = [&](const Box& box) {
    const Eigen::Vector3f size = (box.high - box.low) / static_cast<float>(kTexel);
    for (int face = 0; face < 6; ++face) {
      const int axis = face / 2;
      const int columns = static_cast<int>(axis == 0 ? size.y() : size.x());
      const int rows = static_cast<int>(axis == 2 ? size.y() : size.z());
      textures_.push_back(pyramid(print(rows, columns, random)));
    }
  };
  add(walls_);
  for (const Box& box : furniture_) add(box);
}

Room::Surface Room::nearest(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const {
  const Eigen::Vector3f inverse =
      direction.unaryExpr([](float d) { return 1 / (std::abs(d) < 1e-9F ? 1e-9F : d); });
  // Distances to the planes through a box's sides: first the planes through which the ray enters, then
  // the planes through which it leaves.
  const auto sides = [&](const Box& box) {
    const Eigen::Vector3f low = (box.low - origin).cwiseProduct(inverse),
                          high = (box.high - origin).cwiseProduct(inverse);
    return std::pair<Eigen::Vector3f, Eigen::Vector3f>(low.cwiseMin(high), low.cwiseMax(high));
  };
  int axis = 0;
  const float wall = sides(walls_).second.minCoeff(&axis);  // from inside
  Surface best{wall, 2 * axis + (direction(axis) > 0 ? 1 : 0), axis};
  for (std::size_t i = 0; i < furniture_.size(); ++i) {
    const auto [in, out] = sides(furniture_[i]);
    const float enter = in.maxCoeff(&axis);
    if (enter > 0 && enter < std::min(best.distance, out.minCoeff()))
      best = {enter, static_cast<int>(6 * (i + 1)) + 2 * axis + (direction(axis) > 0 ? 0 : 1), axis};
  }
  return best;
}

float Room::gray(const Surface& surface, const Eigen::Vector3f& point, float footprint) const {
  const auto owner = static_cast<std::size_t>(surface.texture / 6);
  const Eigen::Vector3f low = owner == 0 ? walls_.low : furniture_[owner - 1].low;
  const Eigen::Vector3f at = (point - low) / static_cast<float>(kTexel);
  const float u = surface.axis == 0 ? at.y() : at.x(), v = surface.axis == 2 ? at.y() : at.z();
  const float level = std::clamp(std::log2(footprint / static_cast<float>(kTexel)), 0.0F, kLevels - 1.001F);
  const int fine = static_cast<int>(level);
  const auto& texture = textures_[static_cast<std::size_t>(surface.texture)];
  const auto value = [&](int i) {
    const float scale = std::ldexp(1.0F, -i);
    return bilinear(texture[static_cast<std::size_t>(i)], (u + 0.5F) * scale - 0.5F,
                    (v + 0.5F) * scale - 0.5F);
  };
  const float blend = level - static_cast<float>(fine);
  return (1 - blend) * value(fine) + blend * value(fine + 1);
}

cv::Mat Room::render(const Camera& camera, const Eigen::Isometry3d& X_WC, int side) const {
  const auto& lens = camera.intrinsics();
  cv::Mat image(lens.height_px, lens.width_px, CV_8UC1);
  const Eigen::Matrix3f R = X_WC.linear().cast<float>();
  const Eigen::Vector3f origin = X_WC.translation().cast<float>();
  const float pixel = 1 / static_cast<float>(side * lens.fv_px);  // rad
  for (int row = 0; row < image.rows; ++row)
    for (int column = 0; column < image.cols; ++column) {
      float sum = 0;
      for (int k = 0; k < side * side; ++k) {
        const Eigen::Vector2d at(column + (k % side + 0.5) / side - 0.5, row + (k / side + 0.5) / side - 0.5);
        const Eigen::Vector3f h = R * camera.unproject(at)->h.cast<float>().normalized();
        const Surface surface = nearest(origin, h);
        const float oblique = std::sqrt(std::max(0.05F, std::abs(h(surface.axis))));
        sum += gray(surface, origin + surface.distance * h, surface.distance * pixel / oblique);
      }
      image.ptr<uchar>(row)[column] = static_cast<uchar>(std::lround(sum / static_cast<float>(side * side)));
    }
  return image;
}

Eigen::Vector3d Room::hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  const Eigen::Vector3d unit = direction.normalized();
  return origin + nearest(origin.cast<float>(), unit.cast<float>()).distance * unit;
}

Stamp Walk::stamp(int frame) const { return Stamp(std::llround(frame * 1e9 / rate_hz)); }

Eigen::Isometry3d Walk::X_WC(double t) const {
  const double walked = std::max(0.0, t - stand_s), ramp = std::min(1.0, walked / step_s);
  const double ease = ramp * ramp * (3 - 2 * ramp);
  const double end = duration_s - stand_s;
  // speed grows over the first step: phase' = ease
  const double phase =
      walked < step_s ? step_s * (ramp * ramp * ramp - ramp * ramp * ramp * ramp / 2) : walked - step_s / 2;
  const double angle = 2 * std::numbers::pi * turns * phase / (end - step_s / 2);
  const double wave = std::numbers::pi * walked / step_s;
  const Eigen::Matrix3d R_WB = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d center(0, radius_m, 0);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = heading(angle);
  X.translation() = center - R_WB * center + Eigen::Vector3d(0, 0, 1.4) +
                    R_WB * Eigen::Vector3d(0, ease * sway_m * std::sin(wave), 0) +
                    Eigen::Vector3d(0, 0, ease * bounce_m * std::sin(2 * wave));
  return X;
}

Calibration calibration() {
  Calibration c;
  Eigen::Matrix3d R_CG;  // G: x ahead, y left, z up
  R_CG << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  c.X_CG.linear() = R_CG;
  c.X_CG.translation() = Eigen::Vector3d(0, 0.35, -0.15);
  return c;
}

std::vector<cv::Mat> render(const Room& room, const Walk& walk, int side) {
  const Camera camera(calibration().camera);
  std::vector<cv::Mat> images;
  for (int k = 0; k < walk.frames(); ++k)
    images.push_back(room.render(camera, walk.X_WC(seconds(walk.stamp(k))), side));
  return images;
}

Recording::Recording(const Walk& walk, std::vector<cv::Mat> images)
    : walk_(walk), images_(std::move(images)) {
  Eigen::Isometry3d X_PC = walk.X_WC(0);
  const Eigen::Matrix3d begun = X_PC.linear() * heading(0).transpose();
  double yaw = std::atan2(begun(1, 0), begun(0, 0));
  for (int k = 0; k < walk.frames(); ++k) {
    const double t = seconds(walk.stamp(k)), before = k == 0 ? t : seconds(walk.stamp(k - 1));
    const Eigen::Isometry3d now = walk.X_WC(t), last = walk.X_WC(before);
    const Eigen::Matrix3d turned = now.linear() * last.linear().transpose();
    const double dyaw = std::atan2(turned(1, 0), turned(0, 0));
    Eigen::Vector3d step = (1 + walk.slip) * (now.translation() - last.translation());
    step = X_PC.linear() * last.linear().transpose() * step;
    yaw += (1 + walk.yaw_error) * dyaw;
    X_PC.linear() = heading(yaw);
    X_PC.translation() += step;
    X_PC.translation().z() = now.translation().z();
    plan_.push_back(X_PC);
  }
}

std::vector<InertialSample> Recording::inertial(int frame, bool accelerometer, std::uint64_t salt) const {
  std::vector<InertialSample> samples;
  if (frame == 0) return samples;
  const Eigen::Isometry3d X_CG = calibration().X_CG;
  constexpr std::int64_t kTick = 5000000;
  Normal normal(1000003 + static_cast<std::uint64_t>(frame) * 7919 + salt);
  const Stamp end = walk_.stamp(frame);
  for (Stamp begin = walk_.stamp(frame - 1); begin < end;) {
    const Stamp next = std::min(end, Stamp((begin.count() / kTick + 1) * kTick));
    const double a = seconds(begin), b = seconds(next), dt = b - a;
    const auto X_WG = [&](double t) { return walk_.X_WC(t) * X_CG; };
    Eigen::Vector3d value;
    if (accelerometer) {
      constexpr double e = 1e-4;
      const auto v = [&](double t) -> Eigen::Vector3d {
        return (X_WG(t + e).translation() - X_WG(t - e).translation()) / (2 * e);
      };
      value = X_WG((a + b) / 2).linear().transpose() * ((v(b) - v(a)) / dt + Eigen::Vector3d(0, 0, 9.81));
    } else {
      const Eigen::AngleAxisd turn(Eigen::Matrix3d(X_WG(a).linear().transpose() * X_WG(b).linear()));
      value = turn.angle() * turn.axis() / dt;
    }
    const double sigma = accelerometer ? walk_.accelerometer_sigma_m_s2 : walk_.gyro_sigma_rad_s;
    const double white =
        sigma * std::sqrt(0.005 / dt);  // the same density over a reading cut short by a frame
    value += white * Eigen::Vector3d(normal(), normal(), normal());
    samples.push_back({begin, next, value});
    begin = next;
  }
  return samples;
}

Observation Recording::observation(int frame) const {
  const auto i = static_cast<std::size_t>(frame);
  Observation o;
  o.t = walk_.stamp(frame);
  o.gyro = inertial(frame, false, 11);
  o.accelerometer = inertial(frame, true, 13);
  PlannedMotion plan;
  plan.X_PC = plan_[i];
  o.plan = plan;
  if (images_.empty()) return o;
  o.image = images_[i].clone();
  std::mt19937_64 random(104729 + i);
  for (int p = 0; p < o.image.rows * o.image.cols;
       p += 4) {  // sums of 4 uniform bytes: nearly normal, σ 147.8
    const std::uint64_t bits = random(), more = random();
    for (int k = 0; k < 4; ++k) {
      const std::uint64_t b = (bits >> (16 * k)) & 0xffff, m = (more >> (16 * k)) & 0xffff;
      const auto sum = static_cast<double>((b & 0xff) + (b >> 8) + (m & 0xff) + (m >> 8)) - 510;
      uchar& gray = o.image.ptr<uchar>()[p + k];
      gray = cv::saturate_cast<uchar>(gray + walk_.image_sigma / 147.8 * sum);
    }
  }
  return o;
}

Recording recorded(double duration_s, double turns, double rate_hz) {
  Walk walk;
  walk.duration_s = duration_s, walk.turns = turns, walk.rate_hz = rate_hz;
  return Recording(walk, render(Room(), walk));
}

}  // namespace slam::synthetic
