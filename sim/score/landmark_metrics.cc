#include "sim/score/landmark_metrics.h"

#include "sim/score/scored.h"

namespace sim::score {
namespace {

using S = const Scored&;
using Errors = std::vector<LandmarkError>;

// of(the errors of the landmarks)
template <typename F>
auto of_map(F of) {
  return [of](S s) -> Value {
    const auto errors =
        landmark_errors(s.run.map, s.run.landmarks, s.run.truth_camera, s.run.surfaces, s.run.camera);
    if (errors.empty()) return Value::none("the final map has no landmark whose surface point is known");
    return of(errors);
  };
}

std::vector<double> distances(const Errors& errors) {
  std::vector<double> all;
  for (const LandmarkError& error : errors) all.push_back(error.distance);
  return all;
}

Value mean_nees(const Errors& errors) {
  std::vector<double> squares;
  for (const LandmarkError& error : errors)
    if (error.nees) squares.push_back(*error.nees);
  if (squares.size() != errors.size()) return Value::none("a landmark's covariance is not positive definite");
  return mean(squares);
}

}  // namespace

MetricDefinitions landmark_metrics() {
  const std::string error =
      " distance of the final map's landmarks from where the ray through their first pixel, from the true "
      "camera, meets the room.";
  return {{"landmark_rmse_m", "m", "Root mean square" + error, Needs::scale,
           of_map([](const Errors& errors) { return root_mean_square(distances(errors)); })},
          {"landmark_median_m", "m", "Median" + error, Needs::scale,
           of_map([](const Errors& errors) { return median(distances(errors)); })},
          {"landmark_nees_mean", "1",
           "Mean of the squared errors of landmark_rmse_m, normalised by the landmarks' covariances; 3 is "
           "expected.",
           Needs::scale, of_map(mean_nees), Direction::away_from(3)},
          {"landmarks_scored", "1",
           "Number of landmarks of the final map over which landmark_rmse_m is taken.", Needs::estimate,
           of_map([](const Errors& errors) { return static_cast<double>(errors.size()); }), Worst::smallest}};
}

}  // namespace sim::score
