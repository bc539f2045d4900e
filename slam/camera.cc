#include "slam/camera.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace slam {
namespace {

constexpr double kWidest = 1.5;  // rad; a ray (x, y, 1) cannot reach π/2
constexpr double kNarrowest_rad = 0.1;
constexpr double kLeastForward = 1e-6;  // minimum h.z()/|h|; excludes points at or behind the camera
constexpr int kUndistortIterations = 50;
constexpr double kConverged = 1e-13;  // step size for rays and angles, which are of order 1

/// An image point in px relative to the principal point, with its Jacobian with respect to the point it
/// was computed from.
struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d J;
};

// Brown's model and the equidistant model map n = (x/z, y/z) to g(n); these functions also give ∂g/∂n.

Distorted distort_normalized(const RadialTangential& k, const Eigen::Vector2d& n) {
  const double a = n.x(), b = n.y(), r2 = n.squaredNorm();
  const double radial = 1 + r2 * (k.k1 + r2 * k.k2), slope = 2 * (k.k1 + 2 * k.k2 * r2);
  Distorted distorted{radial * n, {}};
  distorted.point +=
      Eigen::Vector2d(2 * k.p1 * a * b + k.p2 * (r2 + 2 * a * a), k.p1 * (r2 + 2 * b * b) + 2 * k.p2 * a * b);
  const double across = slope * a * b + 2 * k.p1 * a + 2 * k.p2 * b;
  distorted.J << radial + slope * a * a + 2 * k.p1 * b + 6 * k.p2 * a, across, across,
      radial + slope * b * b + 6 * k.p1 * b + 2 * k.p2 * a;
  return distorted;
}

/// θ + k₁θ³ + k₂θ⁵ + k₃θ⁷ + k₄θ⁹ and its derivative.
struct DistortedAngle {
  double value, slope;
};
DistortedAngle distort_angle(const Equidistant& k, double a) {
  const double a2 = a * a;
  return {a * (1 + a2 * (k.k1 + a2 * (k.k2 + a2 * (k.k3 + a2 * k.k4)))),
          1 + a2 * (3 * k.k1 + a2 * (5 * k.k2 + a2 * (7 * k.k3 + a2 * 9 * k.k4)))};
}

Distorted distort_normalized(const Equidistant& k, const Eigen::Vector2d& n) {
  const double r = n.norm();
  if (r < 1e-8) return {n, Eigen::Matrix2d::Identity()};
  const DistortedAngle angle = distort_angle(k, std::atan(r));
  const double scale = angle.value / r, slope = (angle.slope / (1 + r * r) - scale) / r;
  return {scale * n, scale * Eigen::Matrix2d::Identity() + slope / r * n * n.transpose()};
}

std::optional<Eigen::Vector2d> undistort_normalized(const RadialTangential& k, const Eigen::Vector2d& m) {
  Eigen::Vector2d n = m;
  for (int i = 0; i < kUndistortIterations; ++i) {
    const Distorted distorted = distort_normalized(k, n);
    const Eigen::Vector2d step = distorted.J.inverse() * (m - distorted.point);
    n += step;
    if (step.norm() < kConverged * (1 + n.norm())) return n;
  }
  return std::nullopt;
}

std::optional<Eigen::Vector2d> undistort_normalized(const Equidistant& k, const Eigen::Vector2d& m) {
  const double distorted = m.norm();
  if (distorted < 1e-8) return m;
  double angle = distorted;
  for (int i = 0; i < kUndistortIterations; ++i) {
    const DistortedAngle now = distort_angle(k, angle);
    const double step = (distorted - now.value) / now.slope;
    angle += step;
    if (std::abs(step) >= kConverged) continue;
    if (!(angle > 0 && angle < kWidest)) break;
    return std::tan(angle) / distorted * m;
  }
  return std::nullopt;
}

/// The distorted image point of u_c = (fu x/z, fv y/z) in a pinhole camera with these focal lengths. Defined
/// everywhere, but one-to-one only within the valid field of view.
template <typename Model>
Distorted distort(const Model& k, const Eigen::Vector2d& focal, const Eigen::Vector2d& u_c) {
  const Distorted distorted = distort_normalized(k, u_c.cwiseQuotient(focal));
  return {focal.cwiseProduct(distorted.point),
          focal.asDiagonal() * distorted.J * focal.cwiseInverse().asDiagonal()};
}

/// The inverse of distort(). Returns nothing if no ray maps to d. The result is meaningless beyond the valid
/// field of view.
template <typename Model>
std::optional<Distorted> undistort(const Model& k, const Eigen::Vector2d& focal, const Eigen::Vector2d& d) {
  const auto n = undistort_normalized(k, d.cwiseQuotient(focal));
  if (!n) return std::nullopt;
  const Eigen::Vector2d u_c = focal.cwiseProduct(*n);
  return Distorted{u_c, distort(k, focal, u_c).J.inverse()};
}

// u_d = u_c/√(1 + 2K₁|u_c|²), in px because K₁ refers to px.
Distorted distort(const OneParameterRadial& k, const Eigen::Vector2d&, const Eigen::Vector2d& u) {
  const double f = 1 + 2 * k.k1_px2 * u.squaredNorm();
  const double root = std::sqrt(f);
  return {u / root, Eigen::Matrix2d::Identity() / root - 2 * k.k1_px2 / (f * root) * u * u.transpose()};
}

std::optional<Distorted> undistort(const OneParameterRadial& k, const Eigen::Vector2d&,
                                   const Eigen::Vector2d& d) {
  const double g = 1 - 2 * k.k1_px2 * d.squaredNorm();
  if (!(g > 1e-3)) return std::nullopt;
  const double root = std::sqrt(g);
  return Distorted{d / root,
                   Eigen::Matrix2d::Identity() / root + 2 * k.k1_px2 / (g * root) * d * d.transpose()};
}

/// The derivative of the image radius with respect to the angle from the axis, up to a positive factor.
double radial_slope(const OneParameterRadial&, double) { return 1; }
double radial_slope(const RadialTangential& k, double angle) {
  const double r2 = std::tan(angle) * std::tan(angle);
  return 1 + r2 * (3 * k.k1 + r2 * 5 * k.k2);
}
double radial_slope(const Equidistant& k, double angle) { return distort_angle(k, angle).slope; }

}  // namespace

Camera::Camera(const CameraIntrinsics& intrinsics)
    : intrinsics_(intrinsics),
      focal_(intrinsics.fu_px, intrinsics.fv_px),
      center_(intrinsics.u0_px, intrinsics.v0_px),
      widest_(std::numeric_limits<double>::infinity()) {
  if (intrinsics.width_px < 32 || intrinsics.height_px < 32 ||
      !(16 * focal_.minCoeff() > intrinsics.width_px))
    throw std::invalid_argument(
        "camera: the focal lengths in px must exceed 1/16 of the width, and the image must be at least 32 px "
        "on each side");
  if (const auto* radial = std::get_if<OneParameterRadial>(&intrinsics.lens)) {
    if (!(radial->k1_px2 >= 0)) throw std::invalid_argument("camera: k1_px2 must not be negative");
    return;
  }
  constexpr double kStep = 1e-3;
  const auto slope = [&](double angle) {
    return std::visit([&](const auto& k) { return radial_slope(k, angle); }, intrinsics.lens);
  };
  double angle = 0;  // beyond the largest valid angle, the models' polynomials fold back
  while (angle < kWidest && slope(angle + kStep) > 0) angle += kStep;
  widest_ = std::tan(angle);
  if (!(widest_ > std::tan(kNarrowest_rad)))
    throw std::invalid_argument("camera: the distortion coefficients do not describe a lens");
}

std::optional<Projection> Camera::project(const Eigen::Vector3d& h) const {
  if (!(h.z() > kLeastForward * h.norm())) return std::nullopt;
  if (!(h.head<2>().norm() <= widest_ * h.z())) return std::nullopt;
  const Eigen::Vector2d u = focal_.cwiseProduct(h.head<2>()) / h.z();
  Matrix23d du_dh;
  du_dh << focal_.x() / h.z(), 0, -u.x() / h.z(), 0, focal_.y() / h.z(), -u.y() / h.z();
  const Distorted distorted =
      std::visit([&](const auto& k) { return distort(k, focal_, u); }, intrinsics_.lens);
  return Projection{center_ + distorted.point, distorted.J * du_dh};
}

std::optional<Ray> Camera::unproject(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d d = pixel - center_;
  const auto undistorted =
      std::visit([&](const auto& k) { return undistort(k, focal_, d); }, intrinsics_.lens);
  if (!undistorted) return std::nullopt;
  Ray ray{Eigen::Vector3d::Ones(), Matrix32d::Zero()};
  ray.h.head<2>() = undistorted->point.cwiseQuotient(focal_);
  if (!(ray.h.head<2>().norm() <= widest_)) return std::nullopt;
  ray.J.topRows<2>() = focal_.cwiseInverse().asDiagonal() * undistorted->J;
  return ray;
}

bool Camera::inside(const Eigen::Vector2d& pixel, double margin_px) const {
  return pixel.x() >= margin_px && pixel.y() >= margin_px &&
         pixel.x() <= intrinsics_.width_px - 1 - margin_px &&
         pixel.y() <= intrinsics_.height_px - 1 - margin_px;
}

double Camera::sigma(const Eigen::Vector2d& pixel, double sigma_px) const {
  return sigma_px * (1 + (pixel - center_).norm() / center_.norm());
}

}  // namespace slam
