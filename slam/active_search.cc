#include "slam/active_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "slam/ellipse_search.h"

namespace slam {
namespace {

constexpr double kBorder = kPatchHalf + 2;  // px
constexpr double kSearchSigmas = 3;
constexpr double kRefinementGain = 0.15;  // correlation that the sub-pixel refinement may still add

bool more_informative(const Candidate& a, const Candidate& b) {
  const double trace_a = a.S.trace(), trace_b = b.S.trace();
  return trace_a > trace_b || (trace_a == trace_b && a.index < b.index);
}

}  // namespace

std::optional<Candidate> predict_landmark(const Kalman& kalman, const Landmark& landmark,
                                          const LandmarkKind& kind, const Camera& camera, double sigma_px) {
  const State& state = kalman.state();
  const Parameters y = landmark.parameters(state);
  const Direction d = direction(kind, y, state.position(), state.orientation());
  const auto projection = camera.project(d.h_C);
  if (!projection || !camera.inside(projection->pixel, kBorder)) return std::nullopt;
  const Eigen::Vector3d p_W = position(kind, y);
  const auto change = view_change(camera, landmark.X_WC_first, state.X_WC(), p_W,
                                  surface_normal(landmark.X_WC_first, p_W, landmark.tilt), projection->pixel);
  if (!change || !(change->determinant() > 0.25 && change->determinant() < 4)) return std::nullopt;

  Measurement m(2);
  m.H_robot.middleCols(kPosition, 3) = projection->J * d.J_r;
  m.H_robot.middleCols(kOrientation, 4) = projection->J * d.J_q;
  m.H_landmark = projection->J * d.J_y;
  m.landmark_at = landmark.at;
  m.sensitivity.col(kLensDistortion).head<2>() = -camera.displacement(d.h_C, projection->pixel);
  const double sigma = camera.sigma(projection->pixel, sigma_px);
  m.R.diagonal().setConstant(sigma * sigma);
  kalman.constrain(m);
  return Candidate{0, projection->pixel, m, innovation_covariance(state, m), *change};
}

void predict_view(const Kalman& kalman, const std::vector<Landmark>& landmarks, const Camera& camera,
                  double sigma_px, std::vector<Candidate>& candidates) {
  candidates.clear();
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    if (std::holds_alternative<SemiInfiniteLine>(landmarks[i].kind)) continue;
    auto candidate = predict_landmark(kalman, landmarks[i], landmarks[i].kind, camera, sigma_px);
    if (!candidate) continue;
    candidate->index = i;
    candidates.push_back(*candidate);
  }
}

void keep_most_informative(std::vector<Candidate>& candidates, std::size_t count) {
  if (candidates.size() <= count) return;
  std::sort(candidates.begin(), candidates.end(), more_informative);
  candidates.resize(count, candidates.front());
}

void keep_affordable(std::vector<Candidate>& candidates, int most_px) {
  std::int64_t left = most_px;
  for (const Candidate& candidate : candidates) left -= searched_pixels(candidate.S, kSearchSigmas);
  if (left >= 0) return;
  std::sort(candidates.begin(), candidates.end(), more_informative);
  left = most_px;
  const auto too_much = [&](const Candidate& candidate) {
    const int pixels = searched_pixels(candidate.S, kSearchSigmas);
    if (pixels > left) return true;
    left -= pixels;
    return false;
  };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), too_much), candidates.end());
}

std::optional<Measurement> search_candidate(const cv::Mat& image, const Landmark& landmark,
                                            const Candidate& candidate, const Options::Vision& options) {
  const auto patch =
      warp(landmark.patch,
           options.warped_patches ? candidate.view_change : Eigen::Matrix2d(Eigen::Matrix2d::Identity()));
  if (!patch) return std::nullopt;
  auto match = search_ellipse(image, *patch, candidate.pixel, candidate.S, kSearchSigmas);
  if (!match || match->correlation < options.minimum_correlation - (options.sub_pixel ? kRefinementGain : 0))
    return std::nullopt;
  if (options.sub_pixel) match = refine(image, *patch, match->pixel);
  if (!match || match->correlation < options.minimum_correlation) return std::nullopt;
  Measurement m = candidate.measurement;
  m.innovation = match->pixel - candidate.pixel;
  return m;
}

}  // namespace slam
