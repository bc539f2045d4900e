#include "slam/surface.h"

namespace slam {
namespace {

constexpr double kStep = 0.1;          // tangent of an angle
constexpr double kLargest = 1.8;       // tangent of an angle
constexpr double kLeastGain = 0.0005;  // of the correlation by a step
constexpr double kPrior = 0.005;       // penalty at a tilt of 45°: most surfaces face the camera

}  // namespace

Eigen::Vector2d refined_tilt(const cv::Mat& image, const Landmark& landmark, const Eigen::Vector2d& pixel,
                             const Camera& camera, const State& state) {
  const Eigen::Vector3d p_W = position(landmark.kind, landmark.parameters(state));
  const Eigen::Isometry3d X_WC = state.X_WC();
  const auto correlation = [&](const Eigen::Vector2d& tilt) {
    const Eigen::Vector3d normal_W = surface_normal(landmark.X_WC_first, p_W, tilt);
    const auto change = view_change(camera, landmark.X_WC_first, X_WC, p_W, normal_W, pixel);
    const auto patch = change ? warp(landmark.patch, *change) : std::nullopt;
    const auto match = patch ? refine(image, *patch, pixel) : std::nullopt;
    return (match ? match->correlation : 0) - kPrior * tilt.squaredNorm();
  };
  Eigen::Vector2d best = landmark.tilt;
  double best_correlation = correlation(landmark.tilt) + kLeastGain;
  for (const Eigen::Vector2d& step : {Eigen::Vector2d(-kStep, 0), Eigen::Vector2d(kStep, 0),
                                      Eigen::Vector2d(0, -kStep), Eigen::Vector2d(0, kStep)}) {
    const Eigen::Vector2d tilt = landmark.tilt + step;
    if (tilt.norm() > kLargest) continue;
    if (const double c = correlation(tilt); c > best_correlation) best_correlation = c, best = tilt;
  }
  return best;
}

}  // namespace slam
