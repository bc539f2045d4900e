#include "sim/score/landmark_accuracy.h"

#include <algorithm>

#include "sim/score/consistency.h"

namespace sim::score {
namespace {

/// Points of the ray through `seen`, each as far from the camera as the surface that a pixel of the template
/// shows.
std::vector<Eigen::Vector3d> template_points(const StampedPixel& seen, int half_px,
                                             const Eigen::Isometry3d& X_WC,
                                             const std::vector<Surface>& surfaces, const TrueCamera& camera) {
  const auto ray = [&](int du, int dv) -> Eigen::Vector3d {
    return X_WC.linear() * camera.bearing(seen.pixel + Eigen::Vector2d(du, dv));
  };
  std::vector<Eigen::Vector3d> points;
  for (int dv = -half_px; dv <= half_px; ++dv)
    for (int du = -half_px; du <= half_px; ++du)
      if (const auto distance = first_hit(surfaces, X_WC.translation(), ray(du, dv)))
        points.push_back(X_WC.translation() + *distance * ray(0, 0));
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
    std::optional<double> nees = normalised_square(error, point.covariance), least = nees;
    const Eigen::Isometry3d& X_WC = pose_at(truth_X_WC, history->begun.t)->X;
    for (const auto& of_W : template_points(history->begun, template_half_px, X_WC, surfaces, camera))
      if (least) least = std::min(least, normalised_square(of_W - point.p_W, point.covariance));
    errors.push_back({point.id, error.norm(), nees, least});
  }
  return errors;
}

}  // namespace sim::score
