#include "slam/vision/active_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace slam {
namespace {

constexpr double kBorder = kPatchHalf + 2;  // px
constexpr double kSearchSigmas = 3;
constexpr double kRefinementGain = 0.15;  // correlation that sub-pixel refinement may still add

bool more_informative(const Candidate& a, const Candidate& b) {
  const double trace_a = a.S.trace(), trace_b = b.S.trace();
  return trace_a > trace_b || (trace_a == trace_b && a.index < b.index);
}

constexpr double kTiltStep = 0.1;          // tangent of an angle
constexpr double kLargestTilt = 1.8;       // tangent of an angle
constexpr double kLeastTiltGain = 0.0005;  // minimum gain in correlation for one step
constexpr double kTiltPrior = 0.005;       // penalty at a tilt of 45°: most surfaces face the camera

constexpr std::size_t kOnStack = 1024;    // columns; regions have fewer
constexpr double kLeastDistance_px = 20;  // minimum distance between the corners of two landmarks
// Number of landmarks up to which a box's sides are a quarter of the image's.
constexpr double kFewVisible = 12;
constexpr double kCornerGateSigmas = 3;
// Mean gray of an image in which corners must pass the whole threshold; ordinary images have 126 or more.
constexpr double kOrdinaryGray = 100, kLeastLight = 0.3;

/// Σ gx², gxgy, gy² over a column of 11 pixels, with doubled gradients so that the sums are integers.
struct Moments {
  std::int32_t xx = 0, xy = 0, yy = 0;
  void add(const Moments& other, std::int32_t sign) {
    xx += sign * other.xx;
    xy += sign * other.xy;
    yy += sign * other.yy;
  }
};

Moments moments_at(const cv::Mat& image, int row, int column) {
  const std::int32_t gx = image.ptr<uchar>(row)[column + 1] - image.ptr<uchar>(row)[column - 1];
  const std::int32_t gy = image.ptr<uchar>(row + 1)[column] - image.ptr<uchar>(row - 1)[column];
  return {gx * gx, gx * gy, gy * gy};
}

/// The smaller eigenvalue of the moments of the actual gradients.
double smaller_eigenvalue(const Moments& m) {
  const double xx = m.xx, xy = m.xy, yy = m.yy;
  return (xx + yy - std::sqrt((xx - yy) * (xx - yy) + 4 * xy * xy)) / 8;
}

/// A box at a random place. It is smaller if more landmarks are wanted, so that they can be closer together.
cv::Rect random_box(const cv::Mat& image, int visible, std::mt19937_64& random) {
  const int margin = kSourceHalf + 1;
  const double side = std::min(1.0, std::sqrt(kFewVisible / visible)) / 4;  // relative to the image's
  const int width = static_cast<int>(side * image.cols), height = static_cast<int>(side * image.rows);
  const auto below = [&random](int n) { return static_cast<int>(random() % static_cast<std::uint64_t>(n)); };
  const int x = margin + below(image.cols - 2 * margin - width + 1);
  const int y = margin + below(image.rows - 2 * margin - height + 1);
  return {x, y, width, height};
}

/// The same as predict_landmark(), but without S.
std::optional<Candidate> project_landmark(const Kalman& kalman, const Landmark& landmark,
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
  m.robot_columns = kRate;  // pose, and velocity because of constrain()
  m.H_robot.middleCols(kPosition, 3) = projection->J * d.J_r;
  m.H_robot.middleCols(kOrientation, 4) = projection->J * d.J_q;
  m.H_landmark = projection->J * d.J_y;
  m.landmark_at = landmark.at;
  m.sensitivity.col(kLensDistortion).head<2>() = -camera.displacement(d.h_C, projection->pixel);
  const double sigma = camera.sigma(projection->pixel, sigma_px);
  m.R.diagonal().setConstant(sigma * sigma);
  kalman.constrain(m);
  return Candidate{0, projection->pixel, m, Eigen::Matrix2d::Zero(), *change};
}

}  // namespace

std::optional<Candidate> predict_landmark(const Kalman& kalman, const Landmark& landmark,
                                          const LandmarkKind& kind, const Camera& camera, double sigma_px) {
  auto candidate = project_landmark(kalman, landmark, kind, camera, sigma_px);
  if (candidate) candidate->S = innovation_covariance(kalman.state(), candidate->measurement);
  return candidate;
}

void predict_view(const Kalman& kalman, const std::vector<Landmark>& landmarks, const Camera& camera,
                  double sigma_px, std::vector<Candidate>& candidates) {
  candidates.clear();
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    if (std::holds_alternative<SemiInfiniteLine>(landmarks[i].kind)) continue;
    auto candidate = project_landmark(kalman, landmarks[i], landmarks[i].kind, camera, sigma_px);
    if (!candidate) continue;
    candidate->index = i;
    candidates.push_back(*candidate);
  }
}

void keep_most_informative(std::vector<Candidate>& candidates, std::size_t count) {
  if (candidates.size() <= count) return;
  for (auto next = candidates.begin(); next != candidates.begin() + static_cast<std::ptrdiff_t>(count);
       ++next)
    std::iter_swap(next, std::min_element(next, candidates.end(), more_informative));
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
  const double wider = options.search_sigma_px() / options.sigma_px;
  const Eigen::Matrix2d S = candidate.S + (wider * wider - 1) * candidate.measurement.R;
  auto match = search_ellipse(image, *patch, candidate.pixel, S, kSearchSigmas);
  if (!match || match->correlation < options.minimum_correlation - (options.sub_pixel ? kRefinementGain : 0))
    return std::nullopt;
  if (options.sub_pixel) match = refine(image, *patch, match->pixel);
  if (!match || match->correlation < options.minimum_correlation) return std::nullopt;
  Measurement m = candidate.measurement;
  m.innovation = match->pixel - candidate.pixel;
  return m;
}

void search_line(const cv::Mat& image, const Kalman& kalman, const Camera& camera,
                 const Options::Vision& options, Landmark& landmark) {
  auto& line = std::get<SemiInfiniteLine>(landmark.kind);
  std::vector<double> likelihoods;
  for (const DepthParticle& particle : line.particles) {
    const SemiInfiniteLine at_this_depth{{{particle.depth_m, 1}}};
    const auto candidate = predict_landmark(kalman, landmark, at_this_depth, camera, options.sigma_px);
    const auto match = candidate ? search_candidate(image, landmark, *candidate, options) : std::nullopt;
    likelihoods.push_back(0);
    if (!match) continue;
    const Eigen::LLT<Eigen::Matrix2d> llt(candidate->S);
    const double distance = llt.matrixL().solve(match->innovation).squaredNorm();
    likelihoods.back() = std::exp(-distance / 2) / llt.matrixL().determinant();
  }
  reweight(line.particles, likelihoods);
  ++line.attempts;
}

Eigen::Vector2d refined_tilt(const cv::Mat& image, const Landmark& landmark, const Eigen::Vector2d& pixel,
                             const Camera& camera, const State& state) {
  const Eigen::Vector3d p_W = position(landmark.kind, landmark.parameters(state));
  const Eigen::Isometry3d X_WC = state.X_WC();
  const auto correlation = [&](const Eigen::Vector2d& tilt) {
    const Eigen::Vector3d normal_W = surface_normal(landmark.X_WC_first, p_W, tilt);
    const auto change = view_change(camera, landmark.X_WC_first, X_WC, p_W, normal_W, pixel);
    const auto patch = change ? warp(landmark.patch, *change) : std::nullopt;
    const auto match = patch ? refine(image, *patch, pixel) : std::nullopt;
    return (match ? match->correlation : 0) - kTiltPrior * tilt.squaredNorm();
  };
  Eigen::Vector2d best = landmark.tilt;
  double best_correlation = correlation(landmark.tilt) + kLeastTiltGain;
  for (const Eigen::Vector2d& step : {Eigen::Vector2d(-kTiltStep, 0), Eigen::Vector2d(kTiltStep, 0),
                                      Eigen::Vector2d(0, -kTiltStep), Eigen::Vector2d(0, kTiltStep)}) {
    const Eigen::Vector2d tilt = landmark.tilt + step;
    if (tilt.norm() > kLargestTilt) continue;
    if (const double c = correlation(tilt); c > best_correlation) best_correlation = c, best = tilt;
  }
  return best;
}

std::optional<Corner> strongest_corner(const cv::Mat& image, const cv::Rect& region, double threshold) {
  const int margin = kPatchHalf + 1;
  const cv::Rect inside = region & cv::Rect(margin, margin, image.cols - 2 * margin, image.rows - 2 * margin);
  if (inside.area() == 0) return std::nullopt;
  const int left = inside.x - kPatchHalf, columns = inside.width + 2 * kPatchHalf;
  cv::AutoBuffer<Moments, kOnStack> sums(static_cast<std::size_t>(columns));
  std::fill_n(sums.data(), columns, Moments{});
  const auto add_row = [&](int row, std::int32_t sign) {
    for (int i = 0; i < columns; ++i)
      sums[static_cast<std::size_t>(i)].add(moments_at(image, row, left + i), sign);
  };
  for (int row = inside.y - kPatchHalf; row < inside.y + kPatchHalf; ++row) add_row(row, 1);
  std::optional<Corner> best;
  for (int row = inside.y; row < inside.y + inside.height; ++row) {
    add_row(row + kPatchHalf, 1);
    Moments window;
    for (int i = 0; i < columns; ++i) {
      window.add(sums[static_cast<std::size_t>(i)], 1);
      if (i >= kPatchSide) window.add(sums[static_cast<std::size_t>(i - kPatchSide)], -1);
      if (i < kPatchSide - 1) continue;
      const double least = best ? best->strength : threshold;
      if (std::min(window.xx, window.yy) <= 4 * least) continue;  // a bound on the eigenvalue
      if (const double strength = smaller_eigenvalue(window); strength > least)
        best = Corner{{left + i - kPatchHalf, row}, strength};
    }
    add_row(row - kPatchHalf, -1);
  }
  return best;
}

std::optional<Eigen::Vector2i> propose_corner(const cv::Mat& image,
                                              const std::vector<Eigen::Vector2d>& occupied,
                                              const Options::Vision& options, std::mt19937_64& random,
                                              double share) {
  const cv::Rect box = random_box(image, options.visible_landmarks, random);
  if (std::any_of(occupied.begin(), occupied.end(),
                  [&](const Eigen::Vector2d& p) { return box.contains(cv::Point2d(p.x(), p.y())); }))
    return std::nullopt;
  // Gradients are proportional to the light; noise is not.
  const double light = std::clamp(cv::mean(image)[0] / kOrdinaryGray, kLeastLight, 1.0);
  share = std::max(share * light * light, kLeastLight * kLeastLight);
  const auto corner = strongest_corner(image, box, share * options.corner_threshold);
  if (!corner) return std::nullopt;
  const Eigen::Vector2d pixel = corner->pixel.cast<double>();
  const double least = std::min<double>(kLeastDistance_px, box.height);
  if (std::any_of(occupied.begin(), occupied.end(),
                  [&](const Eigen::Vector2d& p) { return (p - pixel).norm() < least; }))
    return std::nullopt;
  return corner->pixel;
}

std::optional<Eigen::Vector2d> corner_near(const cv::Mat& image, const Eigen::Vector2d& predicted,
                                           const Eigen::Matrix2d& S) {
  const cv::Point2f start(cv::Point2d(predicted.x(), predicted.y()));
  std::vector<cv::Point2f> at{start};
  const cv::TermCriteria criteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.01);
  cv::cornerSubPix(image, at, {kPatchHalf, kPatchHalf}, {-1, -1}, criteria);
  const Eigen::Vector2d corner(at[0].x, at[0].y), moved = corner - predicted;
  if (at[0] == start || !(moved.dot(S.llt().solve(moved)) < kCornerGateSigmas * kCornerGateSigmas))
    return std::nullopt;
  return corner;
}

}  // namespace slam
