#include "slam/vision/landmark.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "slam/eigen_kernels.h"

namespace slam {
namespace {

constexpr double kLeastInverseDepth = 0.01;  // 1/m, for positions

/// ∂(θ, φ)/∂h of θ = atan2(h_y, h_x), φ = atan2(h_z, √(h_x² + h_y²)).
Matrix23d angles_jacobian(const Eigen::Vector3d& h) {
  const double level2 = h.head<2>().squaredNorm(), level = std::sqrt(level2), all2 = h.squaredNorm();
  Matrix23d J;
  J << -h.y() / level2, h.x() / level2, 0, -h.x() * h.z() / (level * all2), -h.y() * h.z() / (level * all2),
      level / all2;
  return J;
}

/// m(θ, φ), a unit vector, and ∂m/∂(θ, φ).
Eigen::Vector3d bearing(double theta, double phi) {
  return {std::cos(phi) * std::cos(theta), std::cos(phi) * std::sin(theta), std::sin(phi)};
}
Matrix32d bearing_jacobian(double theta, double phi) {
  Matrix32d J;
  J << -std::cos(phi) * std::sin(theta), -std::sin(phi) * std::cos(theta),  //
      std::cos(phi) * std::cos(theta), -std::sin(phi) * std::sin(theta),    //
      0, std::cos(phi);
  return J;
}

constexpr double kDepthStep_m = 1e-3;  // resolution of depth images
constexpr double kPlane = 4;           // largest mean square residual of a planar patch, in sigma²

constexpr double kAnotherView = 0.15;  // motion over distance

constexpr double kNegligible = 0.05;  // as a fraction of the mean probability

}  // namespace

LandmarkInitialization initialize_inverse_depth(const RobotVector& x, const Ray& ray, double sigma_px,
                                                const Eigen::Vector2d& displacement,
                                                const Options::Depth& options,
                                                const std::optional<MeasuredDepth>& measured) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  const Eigen::Matrix3d R_WC = rotation_matrix(q);
  const Eigen::Vector3d h_W = R_WC * ray.h;
  const Matrix23d J_angles = angles_jacobian(h_W);
  LandmarkInitialization landmark{Vector6d::Zero(), Eigen::Matrix<double, 6, kRobot>::Zero(),
                                  Matrix6d::Zero()};
  landmark.y << x.segment<3>(kPosition), std::atan2(h_W.y(), h_W.x()),
      std::atan2(h_W.z(), h_W.head<2>().norm()), options.inverse_1_m;
  landmark.J_robot.block<3, 3>(0, kPosition).setIdentity();
  landmark.J_robot.block<2, 4>(3, kOrientation) = J_angles * rotated_jacobian(q, ray.h);
  double sigma_rho = options.sigma_inverse_1_m;
  Matrix32d J_pixel = Matrix32d::Zero();  // Jacobian of (θ, φ, ρ)
  J_pixel.topRows<2>() = J_angles * R_WC * ray.J;
  if (measured) {
    const double length = ray.h.norm(), cosine = ray.h.z() / length;
    landmark.y(5) = cosine * measured->inverse_1_m;
    sigma_rho = cosine * measured->sigma_1_m;
    const Eigen::Vector3d cosine_by_h = (Eigen::Vector3d::UnitZ() - cosine / length * ray.h) / length;
    J_pixel.row(2) = measured->inverse_1_m * cosine_by_h.transpose() * ray.J;
  }
  landmark.noise.block<3, 3>(3, 3) = sigma_px * sigma_px * J_pixel * J_pixel.transpose();
  landmark.noise(5, 5) += sigma_rho * sigma_rho;
  landmark.distortion.segment<3>(3) = -J_pixel * displacement;
  return landmark;
}

std::optional<MeasuredDepth> DepthImage::at(const Eigen::Vector2i& pixel) const {
  if (mm.empty()) return std::nullopt;
  double sum = 0, by_u = 0, by_v = 0, squares = 0, of_offsets = 0;
  int count = 0;
  for (int v = -kPatchHalf; v <= kPatchHalf; ++v)
    for (int u = -kPatchHalf; u <= kPatchHalf; ++u) {
      const unsigned short depth_mm = mm.at<unsigned short>(pixel.y() + v, pixel.x() + u);
      if (depth_mm == 0) return std::nullopt;
      const double inverse = 1e3 / depth_mm;
      sum += inverse, by_u += u * inverse, by_v += v * inverse;
      squares += inverse * inverse, of_offsets += u * u, ++count;
    }
  const double mean = sum / count, sigma = std::max(sigma_inverse_1_m, kDepthStep_m * mean * mean);
  const double residual = squares - count * mean * mean - (by_u * by_u + by_v * by_v) / of_offsets;
  if (!(residual < kPlane * (count - 3) * sigma * sigma)) return std::nullopt;
  return MeasuredDepth{mean, sigma};
}

double linearity_index(const Vector6d& y, double sigma_rho, const Eigen::Vector3d& r) {
  if (y(5) <= kLeastInverseDepth) return std::numeric_limits<double>::infinity();
  const Eigen::Vector3d p = position(InverseDepth{}, y);
  const Eigen::Vector3d from_now = p - r, from_anchor = p - y.head<3>();
  const double d1 = from_now.norm();
  const double cosine = from_now.dot(from_anchor) / (d1 * from_anchor.norm());
  return 4 * sigma_rho / (y(5) * y(5)) * std::abs(cosine) / d1;
}

std::vector<DepthParticle> uniform_prior(const Options::Depth::Particles& options) {
  std::vector<DepthParticle> particles;
  const double step = (options.furthest_m - options.nearest_m) / options.count;
  for (int i = 0; i < options.count; ++i)
    particles.push_back({options.nearest_m + (i + 0.5) * step, 1.0 / options.count});
  return particles;
}

DepthMoments depth_moments(const std::vector<DepthParticle>& particles) {
  double mean = 0, variance = 0;
  for (const DepthParticle& p : particles) mean += p.probability * p.depth_m;
  for (const DepthParticle& p : particles)
    variance += p.probability * (p.depth_m - mean) * (p.depth_m - mean);
  return {mean, std::sqrt(variance)};
}

void reweight(std::vector<DepthParticle>& particles, const std::vector<double>& likelihoods) {
  const auto normalize = [&] {
    double sum = 0;
    for (const DepthParticle& p : particles) sum += p.probability;
    for (DepthParticle& p : particles) p.probability /= sum;
  };
  for (std::size_t i = 0; i < particles.size(); ++i) particles[i].probability *= likelihoods[i];
  std::erase_if(particles, [](const DepthParticle& p) { return !(p.probability > 0); });
  if (particles.empty()) return;
  normalize();
  const double least = kNegligible / static_cast<double>(particles.size());
  std::erase_if(particles, [least](const DepthParticle& p) { return p.probability < least; });
  normalize();
}

LandmarkInitialization initialize_line(const RobotVector& x, const Ray& ray, double sigma_px) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  const Eigen::Matrix3d R_WC = rotation_matrix(q);
  const double length = ray.h.norm();
  const Eigen::Vector3d h_C = ray.h / length;
  const Eigen::Matrix3d J_unit = (Eigen::Matrix3d::Identity() - h_C * h_C.transpose()) / length;
  const Matrix32d J_pixel = R_WC * J_unit * ray.J;
  LandmarkInitialization line{Vector6d::Zero(), Eigen::Matrix<double, 6, kRobot>::Zero(), Matrix6d::Zero()};
  line.y << x.segment<3>(kPosition), R_WC * h_C;
  line.J_robot.block<3, 3>(0, kPosition).setIdentity();
  line.J_robot.block<3, 4>(3, kOrientation) = rotated_jacobian(q, h_C);
  line.noise.block<3, 3>(3, 3) = sigma_px * sigma_px * J_pixel * J_pixel.transpose();
  return line;
}

Direction direction(const LandmarkKind& kind, const Parameters& y, const Eigen::Vector3d& r,
                    const Eigen::Vector4d& q) {
  const Eigen::Matrix3d R_CW = rotation_matrix(q).transpose();
  Eigen::Vector3d h_W = y.head<3>() - r;
  double weight = 1;
  Direction d;
  if (std::holds_alternative<Point>(kind)) {
    d.J_y = R_CW;
  } else if (const auto* line = std::get_if<SemiInfiniteLine>(&kind)) {
    const double depth = depth_moments(line->particles).mean_m;
    d.J_y.resize(3, 6);
    d.J_y << R_CW, depth * R_CW;
    h_W += depth * y.segment<3>(3);
  } else {
    weight = y(5);
    d.J_y.resize(3, 6);
    d.J_y << weight * R_CW, R_CW * bearing_jacobian(y(3), y(4)), R_CW * h_W;
    h_W = weight * h_W + bearing(y(3), y(4));
  }
  d.h_C = R_CW * h_W;
  d.J_r = -weight * R_CW;
  d.J_q = rotated_back_jacobian(q, h_W);
  return d;
}

Eigen::Vector3d position(const LandmarkKind& kind, const Parameters& y) {
  if (std::holds_alternative<Point>(kind)) return y;
  if (const auto* line = std::get_if<SemiInfiniteLine>(&kind))
    return y.head<3>() + depth_moments(line->particles).mean_m * y.segment<3>(3);
  return y.head<3>() + bearing(y(3), y(4)) / std::max(y(5), kLeastInverseDepth);
}

PositionJacobian position_jacobian(const LandmarkKind& kind, const Parameters& y) {
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  if (std::holds_alternative<Point>(kind)) return identity;
  PositionJacobian J(3, 6);
  if (const auto* line = std::get_if<SemiInfiniteLine>(&kind)) {
    J << identity, depth_moments(line->particles).mean_m * identity;
  } else {
    const double rho = std::max(y(5), kLeastInverseDepth);
    J << identity, bearing_jacobian(y(3), y(4)) / rho, -bearing(y(3), y(4)) / (rho * rho);
  }
  return J;
}

bool Landmark::is_seen_anew(const State& state) const {
  const double distance = (position(kind, parameters(state)) - state.position()).norm();
  return (state.position() - p_WC_missed).norm() > kAnotherView * distance;
}

Eigen::Matrix3d position_covariance(const State& state, const Landmark& landmark) {
  const int at = landmark.at, size = landmark.size();
  const auto J = position_jacobian(landmark.kind, landmark.parameters(state));
  return J * state.storage_P.block(at, at, size, size).selfadjointView<Eigen::Lower>() * J.transpose();
}

}  // namespace slam
