#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "sim/score/run.h"

namespace sim::score {
namespace {

constexpr Stamp kOutOfView = std::chrono::seconds(5);
constexpr double kTolerance_px = 3;

// The true pose of exactly that time, or null.
const Eigen::Isometry3d* pose_at(const Run& run, Stamp t) {
  const auto at = std::ranges::lower_bound(run.truth_camera, t, {}, &TimedPose::t);
  return at != run.truth_camera.end() && at->t == t ? &at->X : nullptr;
}

std::optional<Eigen::Vector3d> surface_point(const Run& run, const StampedPixel& seen) {
  const Eigen::Isometry3d* const X_WC = pose_at(run, seen.t);
  if (!X_WC) return std::nullopt;
  const Eigen::Vector3d direction = X_WC->linear() * run.camera.bearing(seen.pixel);
  const auto distance = first_hit(run.surfaces, X_WC->translation(), direction);
  if (!distance) return std::nullopt;
  return X_WC->translation() + *distance * direction;
}

// The end of the first stretch after `start` with the point out of view for long enough.
std::optional<Stamp> lost_from_view(const Run& run, const Eigen::Vector3d& p_W, Stamp start) {
  std::optional<Stamp> out_since;
  for (const TimedPose& pose : run.truth_camera) {
    if (pose.t < start) continue;
    if (run.camera.project(pose.X, p_W)) {
      out_since.reset();
      continue;
    }
    if (!out_since) out_since = pose.t;
    if (pose.t - *out_since >= kOutOfView) return pose.t;
  }
  return std::nullopt;
}

std::optional<LoopLandmark> found_again(const Run& run, const LandmarkHistory& landmark,
                                        const TurnMarks& marks) {
  if (landmark.first_seen.t >= marks.quarter) return std::nullopt;
  const auto p_W = surface_point(run, landmark.first_seen);
  if (!p_W) return std::nullopt;
  const auto lost = lost_from_view(run, *p_W, landmark.first_seen.t);
  if (!lost) return std::nullopt;
  const auto matches_truth = [&](const StampedPixel& match) {
    const Eigen::Isometry3d* const X_WC = pose_at(run, match.t);
    const auto pixel = X_WC ? run.camera.project(*X_WC, *p_W) : std::nullopt;
    return pixel && (*pixel - match.pixel).norm() <= kTolerance_px;
  };
  const auto match_from = [&](Stamp t) {
    return std::ranges::find_if(landmark.accepted, [&](const StampedPixel& match) {
      return match.t > *lost && match.t >= t && matches_truth(match);
    });
  };
  const auto first = match_from(*lost);
  if (first == landmark.accepted.end()) return std::nullopt;
  return LoopLandmark{landmark.id, first->t, match_from(marks.three_quarters) != landmark.accepted.end()};
}

/// Points of the ray through `seen`, one per surface of the template, as far as its pixel nearest to it.
std::vector<Eigen::Vector3d> template_points(const Run& run, const StampedPixel& seen, int half_px) {
  const Eigen::Isometry3d& X_WC = *pose_at(run, seen.t);
  const auto ray = [&](int du, int dv) -> Eigen::Vector3d {
    return X_WC.linear() * run.camera.bearing(seen.pixel + Eigen::Vector2d(du, dv));
  };
  std::map<std::size_t, std::pair<int, double>>
      shown;  // surface: squared distance from `seen`, px², and from the camera
  for (int dv = -half_px; dv <= half_px; ++dv)
    for (int du = -half_px; du <= half_px; ++du)
      if (const auto hit = first_surface(run.surfaces, X_WC.translation(), ray(du, dv))) {
        const std::pair<int, double> here{du * du + dv * dv, hit->distance};
        const auto [at, is_new] = shown.try_emplace(hit->surface, here);
        if (!is_new) at->second = std::min(at->second, here);
      }
  std::vector<Eigen::Vector3d> points;
  for (const auto& [surface, nearest] : shown)
    points.push_back(X_WC.translation() + nearest.second * ray(0, 0));
  return points;
}

}  // namespace

std::optional<TurnMarks> turn_marks(const Trajectory& plan_waist) {
  std::vector<double> turned;  // since the first pose, without jumps of whole turns
  for (std::size_t i = 0; i < plan_waist.size(); ++i)
    turned.push_back(i == 0 ? 0
                            : turned.back() +
                                  yaw(plan_waist[i].X.linear() * plan_waist[i - 1].X.linear().transpose()));
  if (turned.empty() || std::abs(turned.back()) < 350 * std::numbers::pi / 180) return std::nullopt;
  const auto when = [&](double part) {
    const auto reached =
        std::ranges::find_if(turned, [&](double turn) { return turn / turned.back() >= part; });
    return plan_waist[static_cast<std::size_t>(reached - turned.begin())].t;
  };
  return TurnMarks{when(0.25), when(0.75)};
}

std::vector<LoopLandmark> loop_landmarks(const Run& run, const TurnMarks& marks) {
  std::vector<LoopLandmark> all;
  for (const LandmarkHistory& landmark : run.landmarks)
    if (const auto found = found_again(run, landmark, marks)) all.push_back(*found);
  return all;
}

std::vector<LandmarkError> landmark_errors(const Run& run, int template_half_px) {
  std::vector<LandmarkError> errors;
  for (const MappedPoint& point : run.map) {
    const auto history = std::ranges::find(run.landmarks, point.id, &LandmarkHistory::id);
    if (history == run.landmarks.end()) continue;
    const auto p_W = surface_point(run, history->first_seen);
    if (!p_W) continue;
    const Eigen::Vector3d error = *p_W - point.p_W;
    std::optional<double> nees = normalized_square(error, point.covariance), least = nees;
    for (const Eigen::Vector3d& of_W : template_points(run, history->first_seen, template_half_px))
      if (least) least = std::min(least, normalized_square(of_W - point.p_W, point.covariance));
    errors.push_back({point.id, error.norm(), nees, least});
  }
  return errors;
}

}  // namespace sim::score
