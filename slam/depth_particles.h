// A landmark at first sight as the paper has it: a semi-infinite line, its depth told by particles (Fig. 3).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slam/camera.h"
#include "slam/depth_hypotheses.h"
#include "slam/kalman.h"
#include "slam/options.h"

namespace slam {

/// Davison 2003: y = (c₀, ĥ), the landmark somewhere at c₀ + λĥ, λ > 0; m and a unit vector, W.
struct SemiInfiniteLine {
  static constexpr int kSize = 6;
  std::vector<DepthParticle> particles;
  int attempts = 0;  ///< frames in which it was looked for
};

/// Mean and standard deviation of the depth, m.
struct DepthBelief {
  double mean_m, sigma_m;
};

/// All depths from nearest to furthest alike.
std::vector<DepthParticle> flat_prior(const Options::Depth::Particles& options);

DepthBelief belief(const std::vector<DepthParticle>& particles);

/// p ← p · likelihood for each particle, then p < 0.05/N are dropped and the sum is made 1 (Davison et al.
/// 2007). Empty where no particle is left with any probability.
void reweigh(std::vector<DepthParticle>& particles, const std::vector<double>& likelihoods);

/// A new line along the line of sight `ray` whose pixel has standard deviation sigma_px.
Beginning begin_line(const RobotVector& x, const Ray& ray, double sigma_px);

/// Whether the depth is known well enough for the line to become a point.
bool converged(const SemiInfiniteLine& line, const Options::Depth::Particles& options);

/// Whether too few depths are left, or it has been looked for too often.
bool given_up(const SemiInfiniteLine& line, const Options::Depth::Particles& options);

}  // namespace slam
