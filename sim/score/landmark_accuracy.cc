#include "sim/score/landmark_accuracy.h"

#include <algorithm>
#include <map>
#include <utility>

#include "sim/score/consistency.h"

namespace sim::score {
namespace {

/// Points of the ray through `seen`: of each surface that the template shows one, as far from the camera as
/// that surface is where the template shows it nearest to `seen`.
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

std::vector<LandmarkError> landmark_errors(const std::vector<MappedPoint>& map,
                                           const std::vector<LandmarkHistory>& histories,
                                           const Trajectory& truth_X_WC, const std::vector<Surface>& surfaces,
                                           const TrueCamera& camera, int template_half_px) {
  std::vector<LandmarkError> errors;
  for (const MappedPoint& point : map) {
    const auto history = std::find_if(histories.begin(), histories.end(),
                                      [&](const LandmarkHistory& h) { return h.id == point.id; });
    if (history == histories.end()) continue;
    const auto p_W = surface_point(history->begun, truth_X_WC, surfaces, camera);
    if (!p_W) continue;
    const Eigen::Vector3d error = *p_W - point.p_W;
    std::optional<double> nees = normalized_square(error, point.covariance), least = nees;
    const Eigen::Isometry3d& X_WC = pose_at(truth_X_WC, history->begun.t)->X;
    for (const auto& of_W : template_points(history->begun, template_half_px, X_WC, surfaces, camera))
      if (least) least = std::min(least, normalized_square(of_W - point.p_W, point.covariance));
    errors.push_back({point.id, error.norm(), nees, least});
  }
  return errors;
}

}  // namespace sim::score
