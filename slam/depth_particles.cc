#include "slam/depth_particles.h"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

constexpr double kNegligible = 0.05;  // as a fraction of the mean probability

void normalise(std::vector<DepthParticle>& particles) {
  double sum = 0;
  for (const DepthParticle& p : particles) sum += p.probability;
  for (DepthParticle& p : particles) p.probability /= sum;
}

}  // namespace

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
  for (std::size_t i = 0; i < particles.size(); ++i) particles[i].probability *= likelihoods[i];
  std::erase_if(particles, [](const DepthParticle& p) { return !(p.probability > 0); });
  if (particles.empty()) return;
  normalise(particles);
  const double least = kNegligible / static_cast<double>(particles.size());
  std::erase_if(particles, [least](const DepthParticle& p) { return p.probability < least; });
  normalise(particles);
}

LandmarkInitialisation initialise_line(const RobotVector& x, const Ray& ray, double sigma_px) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  const Eigen::Matrix3d R_WC = rotation_matrix(q);
  const double length = ray.h.norm();
  const Eigen::Vector3d h_C = ray.h / length;
  const Eigen::Matrix3d J_unit = (Eigen::Matrix3d::Identity() - h_C * h_C.transpose()) / length;
  const Matrix32d J_pixel = R_WC * J_unit * ray.J;
  LandmarkInitialisation line{Vector6d::Zero(), Eigen::Matrix<double, 6, kRobot>::Zero(), Matrix6d::Zero()};
  line.y << x.segment<3>(kPosition), R_WC * h_C;
  line.J_robot.block<3, 3>(0, kPosition).setIdentity();
  line.J_robot.block<3, 4>(3, kOrientation) = rotated_jacobian(q, h_C);
  line.noise.block<3, 3>(3, 3) = sigma_px * sigma_px * J_pixel * J_pixel.transpose();
  return line;
}

bool converged(const SemiInfiniteLine& line, const Options::Depth::Particles& options) {
  const DepthMoments depth = depth_moments(line.particles);
  return depth.sigma_m < options.converged * depth.mean_m;
}

bool has_failed(const SemiInfiniteLine& line, const Options::Depth::Particles& options) {
  return static_cast<int>(line.particles.size()) < options.fewest || line.attempts > options.attempts;
}

}  // namespace slam
