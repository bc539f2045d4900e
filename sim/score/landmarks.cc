#include "sim/score/landmarks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "sim/score/consistency.h"

namespace sim::score {
namespace {

constexpr Stamp kOutOfView = std::chrono::seconds(5);
constexpr double kTolerance_px = 3;

// Angles of turn since the first pose, without jumps of whole turns.
std::vector<double> turns(const Trajectory& trajectory) {
  std::vector<double> all;
  for (std::size_t i = 0; i < trajectory.size(); ++i)
    all.push_back(
        i == 0 ? 0 : all.back() + yaw(trajectory[i].X.linear() * trajectory[i - 1].X.linear().transpose()));
  return all;
}

// The end of the first stretch after `start` with the point out of view for long enough.
std::optional<Stamp> lost_from_view(const Eigen::Vector3d& p_W, Stamp start, const Trajectory& truth_X_WC,
                                    const TrueCamera& camera) {
  std::optional<Stamp> out_since;
  for (const TimedPose& pose : truth_X_WC) {
    if (pose.t < start) continue;
    if (camera.project(pose.X, p_W)) {
      out_since.reset();
      continue;
    }
    if (!out_since) out_since = pose.t;
    if (pose.t - *out_since >= kOutOfView) return pose.t;
  }
  return std::nullopt;
}

bool matches_truth(const StampedPixel& match, const Eigen::Vector3d& p_W, const Trajectory& truth_X_WC,
                   const TrueCamera& camera) {
  const TimedPose* pose = pose_at(truth_X_WC, match.t);
  const auto pixel = pose ? camera.project(pose->X, p_W) : std::nullopt;
  return pixel && (*pixel - match.pixel).norm() <= kTolerance_px;
}

/// Points of the ray through `seen`, one for each surface that the template shows: at the distance of the
/// surface's pixel nearest to `seen`.
std::vector<Eigen::Vector3d> template_points(const StampedPixel& seen, int half_px,
                                             const Eigen::Isometry3d& X_WC,
                                             const std::vector<Surface>& surfaces, const TrueCamera& camera) {
  const auto ray = [&](int du, int dv) -> Eigen::Vector3d {
    return X_WC.linear() * camera.bearing(seen.pixel + Eigen::Vector2d(du, dv));
  };
  std::map<std::size_t, std::pair<int, double>>
      shown;  // surface: squared distance from `seen`, px², and from the camera
  for (int dv = -half_px; dv <= half_px; ++dv)
    for (int du = -half_px; du <= half_px; ++du)
      if (const auto hit = first_surface(surfaces, X_WC.translation(), ray(du, dv))) {
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

const TimedPose* pose_at(const Trajectory& trajectory, Stamp t) {
  const auto at = std::lower_bound(trajectory.begin(), trajectory.end(), t,
                                   [](const TimedPose& pose, Stamp stamp) { return pose.t < stamp; });
  return at != trajectory.end() && at->t == t ? &*at : nullptr;
}

std::optional<Eigen::Vector3d> surface_point(const StampedPixel& seen, const Trajectory& truth_X_WC,
                                             const std::vector<Surface>& surfaces, const TrueCamera& camera) {
  const TimedPose* pose = pose_at(truth_X_WC, seen.t);
  if (!pose) return std::nullopt;
  const Eigen::Vector3d direction = pose->X.linear() * camera.bearing(seen.pixel);
  const auto distance = first_hit(surfaces, pose->X.translation(), direction);
  if (!distance) return std::nullopt;
  return pose->X.translation() + *distance * direction;
}

std::optional<TurnMarks> turn_marks(const Trajectory& plan_waist) {
  const std::vector<double> turned = turns(plan_waist);
  if (turned.empty() || std::abs(turned.back()) < 350 * std::numbers::pi / 180) return std::nullopt;
  const auto when = [&](double part) {
    const auto reached =
        std::find_if(turned.begin(), turned.end(), [&](double turn) { return turn / turned.back() >= part; });
    return plan_waist[static_cast<std::size_t>(reached - turned.begin())].t;
  };
  return TurnMarks{when(0.25), when(0.75)};
}

std::vector<LoopLandmark> loop_landmarks(const std::vector<LandmarkHistory>& landmarks,
                                         const TurnMarks& marks, const Trajectory& truth_X_WC,
                                         const std::vector<Surface>& surfaces, const TrueCamera& camera) {
  const auto found_again = [&](const LandmarkHistory& landmark) -> std::optional<LoopLandmark> {
    if (landmark.first_seen.t >= marks.quarter) return std::nullopt;
    const auto p_W = surface_point(landmark.first_seen, truth_X_WC, surfaces, camera);
    if (!p_W) return std::nullopt;
    const auto lost = lost_from_view(*p_W, landmark.first_seen.t, truth_X_WC, camera);
    if (!lost) return std::nullopt;
    const auto match_from = [&](Stamp t) {
      return std::find_if(landmark.accepted.begin(), landmark.accepted.end(), [&](const StampedPixel& match) {
        return match.t > *lost && match.t >= t && matches_truth(match, *p_W, truth_X_WC, camera);
      });
    };
    const auto first = match_from(*lost);
    if (first == landmark.accepted.end()) return std::nullopt;
    return LoopLandmark{landmark.id, first->t, match_from(marks.three_quarters) != landmark.accepted.end()};
  };
  std::vector<LoopLandmark> all;
  for (const LandmarkHistory& landmark : landmarks)
    if (const auto found = found_again(landmark)) all.push_back(*found);
  return all;
}

std::vector<LandmarkError> landmark_errors(const std::vector<MappedPoint>& map,
                                           const std::vector<LandmarkHistory>& histories,
                                           const Trajectory& truth_X_WC, const std::vector<Surface>& surfaces,
                                           const TrueCamera& camera, int template_half_px) {
  std::vector<LandmarkError> errors;
  for (const MappedPoint& point : map) {
    const auto history = std::find_if(histories.begin(), histories.end(),
                                      [&](const LandmarkHistory& h) { return h.id == point.id; });
    if (history == histories.end()) continue;
    const auto p_W = surface_point(history->first_seen, truth_X_WC, surfaces, camera);
    if (!p_W) continue;
    const Eigen::Vector3d error = *p_W - point.p_W;
    std::optional<double> nees = normalized_square(error, point.covariance), least = nees;
    const Eigen::Isometry3d& X_WC = pose_at(truth_X_WC, history->first_seen.t)->X;
    for (const auto& of_W : template_points(history->first_seen, template_half_px, X_WC, surfaces, camera))
      if (least) least = std::min(least, normalized_square(of_W - point.p_W, point.covariance));
    errors.push_back({point.id, error.norm(), nees, least});
  }
  return errors;
}

}  // namespace sim::score
