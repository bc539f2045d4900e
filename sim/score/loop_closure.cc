#include "sim/score/loop_closure.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sim::score {
namespace {

// Angles of turn since the first pose, without jumps of whole turns.
std::vector<double> turns(const Trajectory& trajectory) {
  std::vector<double> all;
  for (std::size_t i = 0; i < trajectory.size(); ++i)
    all.push_back(
        i == 0 ? 0 : all.back() + yaw(trajectory[i].X.linear() * trajectory[i - 1].X.linear().transpose()));
  return all;
}

// When the point has for the first time after `begin` been out of view for long enough.
std::optional<Stamp> lost_from_view(const Eigen::Vector3d& p_W, Stamp begin, const Trajectory& truth_X_WC,
                                    const TrueCamera& camera, Stamp long_enough) {
  std::optional<Stamp> out_since;
  for (const StampedPose& pose : truth_X_WC) {
    if (pose.t < begin) continue;
    if (camera.project(pose.X, p_W)) {
      out_since.reset();
      continue;
    }
    if (!out_since) out_since = pose.t;
    if (pose.t - *out_since >= long_enough) return pose.t;
  }
  return std::nullopt;
}

bool matches_truth(const StampedPixel& match, const Eigen::Vector3d& p_W, const Trajectory& truth_X_WC,
                   const TrueCamera& camera, double tolerance_px) {
  const StampedPose* pose = pose_at(truth_X_WC, match.t);
  const auto pixel = pose ? camera.project(pose->X, p_W) : std::nullopt;
  return pixel && (*pixel - match.pixel).norm() <= tolerance_px;
}

}  // namespace

const StampedPose* pose_at(const Trajectory& trajectory, Stamp t) {
  const auto at = std::lower_bound(trajectory.begin(), trajectory.end(), t,
                                   [](const StampedPose& pose, Stamp stamp) { return pose.t < stamp; });
  return at != trajectory.end() && at->t == t ? &*at : nullptr;
}

std::optional<Eigen::Vector3d> surface_point(const StampedPixel& seen, const Trajectory& truth_X_WC,
                                             const std::vector<Surface>& surfaces, const TrueCamera& camera) {
  const StampedPose* pose = pose_at(truth_X_WC, seen.t);
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
                                         const std::vector<Surface>& surfaces, const TrueCamera& camera,
                                         const LoopRule& rule) {
  const auto found_again = [&](const LandmarkHistory& landmark) -> std::optional<LoopLandmark> {
    if (landmark.begun.t >= marks.quarter) return std::nullopt;
    const auto p_W = surface_point(landmark.begun, truth_X_WC, surfaces, camera);
    if (!p_W) return std::nullopt;
    const auto lost = lost_from_view(*p_W, landmark.begun.t, truth_X_WC, camera, rule.out_of_view);
    if (!lost) return std::nullopt;
    const auto match_from = [&](Stamp t) {
      return std::find_if(landmark.accepted.begin(), landmark.accepted.end(), [&](const StampedPixel& match) {
        return match.t > *lost && match.t >= t &&
               matches_truth(match, *p_W, truth_X_WC, camera, rule.tolerance_px);
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

}  // namespace sim::score
