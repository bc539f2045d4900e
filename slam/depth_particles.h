// A new landmark as in the paper: a semi-infinite line whose depth is estimated by particles (Fig. 3).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slam/camera.h"
#include "slam/depth_hypotheses.h"
#include "slam/kalman.h"
#include "slam/options.h"

namespace slam {

/// Davison 2003: the parameters y = (c₀, ĥ), in m and as a unit vector in W, describe the line c₀ + λĥ,
/// λ > 0, on which the landmark lies.
struct SemiInfiniteLine {
  static constexpr int kSize = 6;
  std::vector<DepthParticle> particles;
  int attempts = 0;  ///< frames in which it was searched for
};

/// Mean and standard deviation of the depth, m.
struct DepthMoments {
  double mean_m, sigma_m;
};

/// Equal probability for all depths from nearest to furthest.
std::vector<DepthParticle> uniform_prior(const Options::Depth::Particles& options);

DepthMoments depth_moments(const std::vector<DepthParticle>& particles);

/// Multiplies each probability by its likelihood, removes particles below 0.05/N and normalises the sum to 1
/// (Davison et al. 2007). No particle is left where all likelihoods are 0.
void reweight(std::vector<DepthParticle>& particles, const std::vector<double>& likelihoods);

/// The parameters of a new line along the ray of a pixel with standard deviation sigma_px.
LandmarkInitialisation initialise_line(const RobotVector& x, const Ray& ray, double sigma_px);

/// True if the depth is known well enough for the line to become a point.
bool converged(const SemiInfiniteLine& line, const Options::Depth::Particles& options);

/// True if too few depths are left or the line has been searched for too often.
bool has_failed(const SemiInfiniteLine& line, const Options::Depth::Particles& options);

}  // namespace slam
