#include "slam/relocalisation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "slam/rotation.h"

namespace slam {
namespace {

constexpr std::size_t kMost = 40;  // landmarks looked for
constexpr int kProven = 10;        // times found before
constexpr double kSurely = 0.85;   // correlation
constexpr double kNear_px = 4;     // of where a pose would have it
constexpr std::size_t kEnough = 6;
constexpr int kIterations = 10;

struct Seen {
  Bearing bearing;
  Eigen::Vector2d pixel;
  Eigen::Matrix3d P;  // of the landmark
};

struct Pixels {  // of a pose: residuals of the seen landmarks
  std::vector<std::size_t> near;
  double squares = 0;
};

Eigen::Matrix3d position_covariance(const State& state, const Landmark& landmark, const Parameters& y) {
  const int at = landmark.at, size = landmark.size();
  const auto J = position_jacobian(landmark.kind, y);
  return J * state.storage_P.block(at, at, size, size).selfadjointView<Eigen::Lower>() * J.transpose();
}

/// Landmarks whose depth is known and that have proven themselves, the most often found first.
std::vector<const Landmark*> proven(const std::vector<Landmark>& landmarks, const State& state) {
  std::vector<const Landmark*> all;
  for (const Landmark& landmark : landmarks) {
    if (landmark.successes < kProven || std::holds_alternative<SemiInfiniteLine>(landmark.kind)) continue;
    const Parameters y = state.storage_x.segment(landmark.at, landmark.size());
    const double away = (position(landmark.kind, y) - landmark.X_WC_first.translation()).norm();
    if (position_covariance(state, landmark, y).trace() < 0.04 * away * away) all.push_back(&landmark);
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto* a, const auto* b) { return a->successes > b->successes; });
  if (all.size() > kMost) all.resize(kMost);
  return all;
}

/// The best correlation of the patch as first seen, anywhere in the image.
std::optional<Match> search_everywhere(const cv::Mat& grey, const Landmark& landmark) {
  const auto patch = warp(landmark.patch, Eigen::Matrix2d::Identity());
  if (!patch) return std::nullopt;
  Eigen::Matrix<float, Template::kPixels, 1> pixels = patch->grey;
  cv::Mat correlation;
  cv::matchTemplate(grey, cv::Mat(kPatchSide, kPatchSide, CV_32F, pixels.data()), correlation,
                    cv::TM_CCOEFF_NORMED);
  double best = 0;
  cv::Point at;
  cv::minMaxLoc(correlation, nullptr, &best, nullptr, &at);
  if (best < kSurely) return std::nullopt;
  return Match{Eigen::Vector2d(at.x + kPatchHalf, at.y + kPatchHalf), best};
}

std::vector<Seen> look_around(const cv::Mat& image, const std::vector<Landmark>& landmarks,
                              const State& state, const Camera& camera) {
  cv::Mat grey;
  image.convertTo(grey, CV_32F);
  std::vector<Seen> all;
  for (const Landmark* landmark : proven(landmarks, state)) {
    const auto match = search_everywhere(grey, *landmark);
    const auto ray = match ? camera.unproject(match->pixel) : std::nullopt;
    if (!ray) continue;
    const Parameters y = state.storage_x.segment(landmark->at, landmark->size());
    all.push_back({{position(landmark->kind, y), ray->h.normalized()},
                   match->pixel,
                   position_covariance(state, *landmark, y)});
  }
  return all;
}

Pixels judge(const Eigen::Isometry3d& X_WC, const std::vector<Seen>& seen, const Camera& camera) {
  Pixels pixels;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto there = camera.project(X_WC.inverse() * seen[i].bearing.p_W);
    if (!there || !((there->pixel - seen[i].pixel).norm() < kNear_px)) continue;
    pixels.near.push_back(i);
    pixels.squares += (there->pixel - seen[i].pixel).squaredNorm();
  }
  return pixels;
}

/// The camera where the lines of sight at this attitude come nearest to meeting.
Eigen::Vector3d meeting(const Bearing& first, const Bearing& second, const Eigen::Matrix3d& R_WC) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Bearing* bearing : {&first, &second}) {
    const Eigen::Vector3d d = R_WC * bearing->direction_C;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    A += across;
    b += across * bearing->p_W;
  }
  return A.ldlt().solve(b);
}

/// Gauss-Newton over the pose; each landmark's own uncertainty counts as noise of its pixel.
Relocation refine(Eigen::Isometry3d X_WC, const std::vector<Seen>& seen, const std::vector<std::size_t>& near,
                  const Camera& camera, double sigma_px) {
  Matrix6d information = Matrix6d::Identity();
  for (int k = 0; k < kIterations; ++k) {
    information.setZero();
    Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
    for (const std::size_t i : near) {
      const Eigen::Vector3d h = X_WC.inverse() * seen[i].bearing.p_W;
      const auto there = camera.project(h);
      if (!there) continue;
      Eigen::Matrix<double, 2, 6> J;
      J << there->J * cross_matrix(h), -there->J * X_WC.linear().transpose();
      const Matrix23d J_p = there->J * X_WC.linear().transpose();
      const Eigen::Matrix2d R =
          sigma_px * sigma_px * Eigen::Matrix2d::Identity() + J_p * seen[i].P * J_p.transpose();
      const Eigen::Matrix<double, 6, 2> JtW = R.llt().solve(J).transpose();
      information += JtW * J;
      gradient += JtW * (seen[i].pixel - there->pixel);
    }
    const Eigen::Matrix<double, 6, 1> step = information.ldlt().solve(gradient);
    X_WC.linear() = X_WC.linear() * rotation_matrix(quaternion_exp(step.head<3>()));
    X_WC.translation() += step.tail<3>();
  }
  return {X_WC, information.ldlt().solve(Matrix6d::Identity()), static_cast<int>(near.size())};
}

}  // namespace

std::vector<Eigen::Isometry3d> poses_from_two(const Bearing& first, const Bearing& second,
                                              const Eigen::Matrix3d& R_WC) {
  const Eigen::Vector3d n = R_WC * first.direction_C.cross(second.direction_C), p = second.p_W - first.p_W;
  const double a = p.x() * n.x() + p.y() * n.y(), b = p.y() * n.x() - p.x() * n.y(), c = p.z() * n.z();
  const double r = std::hypot(a, b);  // a cos ψ + b sin ψ + c = 0
  if (!(r > std::abs(c))) return {};
  std::vector<Eigen::Isometry3d> poses;
  for (const double sign : {-1.0, 1.0}) {
    const double yaw = std::atan2(b, a) + sign * std::acos(-c / r);
    Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
    X_WC.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * R_WC;
    X_WC.translation() = meeting(first, second, X_WC.linear());
    const auto ahead = [&](const Bearing& bearing) {
      return (X_WC.inverse() * bearing.p_W).dot(bearing.direction_C) > 0;
    };
    if (X_WC.translation().allFinite() && ahead(first) && ahead(second)) poses.push_back(X_WC);
  }
  return poses;
}

std::optional<Relocation> relocalise(const cv::Mat& image, const std::vector<Landmark>& landmarks,
                                     const State& state, const Camera& camera, double sigma_px) {
  const std::vector<Seen> seen = look_around(image, landmarks, state, camera);
  Pixels best;
  Eigen::Isometry3d X_best = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < seen.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      for (const auto& X_WC : poses_from_two(seen[i].bearing, seen[j].bearing, state.X_WC().linear())) {
        Pixels pixels = judge(X_WC, seen, camera);
        const bool more = pixels.near.size() > best.near.size();
        const bool closer = pixels.near.size() == best.near.size() && pixels.squares < best.squares;
        if (!more && !closer) continue;
        best = std::move(pixels);
        X_best = X_WC;
      }
  if (best.near.size() < kEnough) return std::nullopt;
  return refine(X_best, seen, best.near, camera, sigma_px);
}

}  // namespace slam
