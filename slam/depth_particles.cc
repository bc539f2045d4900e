#include "slam/depth_particles.h"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

constexpr double kNegligible = 0.05;  // of what each particle would have if all were alike

void make_sum_one(std::vector<DepthParticle>& particles) {
  double sum = 0;
  for (const DepthParticle& p : particles) sum += p.probability;
  for (DepthParticle& p : particles) p.probability /= sum;
}

}  // namespace

std::vector<DepthParticle> flat_prior(const Options::Depth::Particles& options) {
  std::vector<DepthParticle> particles;
  const double step = (options.furthest_m - options.nearest_m) / options.count;
  for (int i = 0; i < options.count; ++i)
    particles.push_back({options.nearest_m + (i + 0.5) * step, 1.0 / options.count});
  return particles;
}

DepthBelief belief(const std::vector<DepthParticle>& particles) {
  double mean = 0, variance = 0;
  for (const DepthParticle& p : particles) mean += p.probability * p.depth_m;
  for (const DepthParticle& p : particles)
    variance += p.probability * (p.depth_m - mean) * (p.depth_m - mean);
  return {mean, std::sqrt(variance)};
}

void reweigh(std::vector<DepthParticle>& particles, const std::vector<double>& likelihoods) {
  for (std::size_t i = 0; i < particles.size(); ++i) particles[i].probability *= likelihoods[i];
  std::erase_if(particles, [](const DepthParticle& p) { return !(p.probability > 0); });
  if (particles.empty()) return;
  make_sum_one(particles);
  const double least = kNegligible / static_cast<double>(particles.size());
  std::erase_if(particles, [least](const DepthParticle& p) { return p.probability < least; });
  make_sum_one(particles);
}

Beginning begin_line(const RobotVector& x, const Ray& ray, double sigma_px) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  const Eigen::Matrix3d R_WC = rotation_matrix(q);
  const double length = ray.h.norm();
  const Eigen::Vector3d h_C = ray.h / length;
  const Eigen::Matrix3d J_unit = (Eigen::Matrix3d::Identity() - h_C * h_C.transpose()) / length;
  const Matrix32d J_pixel = R_WC * J_unit * ray.J;
  Beginning b{Eigen::Matrix<double, 6, 1>::Zero(), Eigen::Matrix<double, 6, kRobot>::Zero(),
              Eigen::Matrix<double, 6, 6>::Zero()};
  b.y << x.segment<3>(kPosition), R_WC * h_C;
  b.J_robot.block<3, 3>(0, kPosition).setIdentity();
  b.J_robot.block<3, 4>(3, kOrientation) = rotated_jacobian(q, h_C);
  b.noise.block<3, 3>(3, 3) = sigma_px * sigma_px * J_pixel * J_pixel.transpose();
  return b;
}

bool converged(const SemiInfiniteLine& line, const Options::Depth::Particles& options) {
  const DepthBelief depth = belief(line.particles);
  return depth.sigma_m < options.converged * depth.mean_m;
}

bool given_up(const SemiInfiniteLine& line, const Options::Depth::Particles& options) {
  return static_cast<int>(line.particles.size()) < options.fewest || line.attempts > options.attempts;
}

}  // namespace slam
