#include "slam/line_search.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "slam/active_search.h"
#include "slam/ellipse_search.h"

namespace slam {
namespace {

double likelihood(const Measurement& m, const Eigen::Matrix2d& S) {
  const Eigen::LLT<Eigen::Matrix2d> llt(S);
  const double distance = llt.matrixL().solve(m.innovation).squaredNorm();
  return std::exp(-distance / 2) / llt.matrixL().determinant();
}

}  // namespace

void search_along(const cv::Mat& image, const Kalman& kalman, const Camera& camera, const Options& options,
                  Landmark& landmark) {
  auto& line = std::get<SemiInfiniteLine>(landmark.kind);
  std::vector<double> likelihoods;
  for (const DepthParticle& particle : line.particles) {
    const SemiInfiniteLine there{{{particle.depth_m, 1}}};
    const auto candidate = predict(kalman, landmark, there, camera, options.vision.sigma_px);
    const auto match = candidate ? find(image, landmark, *candidate, options.vision) : std::nullopt;
    likelihoods.push_back(match ? likelihood(*match, candidate->S) : 0);
  }
  reweigh(line.particles, likelihoods);
  ++line.attempts;
}

}  // namespace slam
