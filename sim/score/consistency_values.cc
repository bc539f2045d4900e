#include <algorithm>

#include "sim/score/metric_values.h"
#include "sim/score/statistics.h"

namespace sim::score {
namespace {

// of(the normalised squares of all frames)
template <typename F>
Value of_nees(const Scored& s, double PoseNees::*part, F of) {
  return of_estimate(s, [&]() -> Value {
    if (s.nees.size() != s.pairs.size())
      return Value::none("a covariance of the estimate is not positive definite");
    std::vector<double> squares;
    for (const PoseNees& nees : s.nees) squares.push_back(nees.*part);
    return of(squares);
  });
}

// of(the errors of the landmarks)
template <typename F>
Value of_map(const Scored& s, F of) {
  return of_estimate(s, [&]() -> Value {
    const auto errors =
        landmark_errors(s.run.map, s.run.landmarks, s.run.truth_camera, s.run.surfaces, s.run.camera);
    if (errors.empty()) return Value::none("the final map has no landmark whose surface point is known");
    return of(errors);
  });
}

std::vector<double> distances(const std::vector<LandmarkError>& errors) {
  std::vector<double> all;
  for (const LandmarkError& error : errors) all.push_back(error.distance);
  return all;
}

}  // namespace

Value nees_mean(const Scored& s, double PoseNees::*part) {
  return of_nees(s, part, [](const std::vector<double>& squares) -> Value { return mean(squares); });
}

Value nees_variance(const Scored& s, double PoseNees::*part) {
  return of_nees(s, part, [](const std::vector<double>& squares) -> Value {
    const double sd = standard_deviation(squares);
    return sd * sd;
  });
}

Value nees_within(const Scored& s, double PoseNees::*part) {
  return of_nees(s, part, [](const std::vector<double>& squares) -> Value {
    const double most = chi_square_quantile(0.95, 3);
    const auto within =
        std::count_if(squares.begin(), squares.end(), [most](double square) { return square <= most; });
    return static_cast<double>(within) / static_cast<double>(squares.size());
  });
}

Value innovations(const Scored& s, std::size_t sensor,
                  const std::function<double(const InnovationSummary&)>& part) {
  return of_estimate(s, [&]() -> Value {
    std::vector<Innovation> all;
    for (const StampedInnovation& innovation : s.run.innovations[sensor])
      if (innovation.t >= *s.begin) all.push_back(innovation.innovation);
    const auto summary = summarise(all);
    if (!summary) return Value::none("the sensor was used in fewer than two frames");
    return part(*summary);
  });
}

Value landmark_rmse(const Scored& s) {
  return of_map(s, [](const auto& errors) -> Value { return root_mean_square(distances(errors)); });
}
Value landmark_median(const Scored& s) {
  return of_map(s, [](const auto& errors) -> Value { return median(distances(errors)); });
}
Value landmarks_scored(const Scored& s) {
  return of_map(s, [](const auto& errors) -> Value { return static_cast<double>(errors.size()); });
}

Value landmark_nees(const Scored& s) {
  return of_map(s, [](const auto& errors) -> Value {
    std::vector<double> squares;
    for (const LandmarkError& error : errors)
      if (error.nees) squares.push_back(*error.nees);
    if (squares.size() != errors.size())
      return Value::none("a landmark's covariance is not positive definite");
    return mean(squares);
  });
}

}  // namespace sim::score
