#include "sim/score/landmark_accuracy.h"

#include <algorithm>

#include "sim/score/consistency.h"

namespace sim::score {

std::vector<LandmarkError> landmark_errors(const std::vector<MappedPoint>& map,
                                           const std::vector<LandmarkHistory>& histories,
                                           const Trajectory& truth_X_WC, const std::vector<Surface>& surfaces,
                                           const TrueCamera& camera) {
  std::vector<LandmarkError> errors;
  for (const MappedPoint& point : map) {
    const auto history = std::find_if(histories.begin(), histories.end(),
                                      [&](const LandmarkHistory& h) { return h.id == point.id; });
    if (history == histories.end()) continue;
    const auto p_W = surface_point(history->begun, truth_X_WC, surfaces, camera);
    if (!p_W) continue;
    const Eigen::Vector3d error = *p_W - point.p_W;
    errors.push_back({point.id, error.norm(), normalised_square(error, point.covariance)});
  }
  return errors;
}

}  // namespace sim::score
