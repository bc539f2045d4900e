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

void search_line(const cv::Mat& image, const Kalman& kalman, const Camera& camera,
                 const Options::Vision& options, Landmark& landmark) {
  auto& line = std::get<SemiInfiniteLine>(landmark.kind);
  std::vector<double> likelihoods;
  for (const DepthParticle& particle : line.particles) {
    const SemiInfiniteLine at_this_depth{{{particle.depth_m, 1}}};
    const auto candidate = predict_landmark(kalman, landmark, at_this_depth, camera, options.sigma_px);
    const auto match = candidate ? search_candidate(image, landmark, *candidate, options) : std::nullopt;
    likelihoods.push_back(match ? likelihood(*match, candidate->S) : 0);
  }
  reweight(line.particles, likelihoods);
  ++line.attempts;
}

}  // namespace slam
