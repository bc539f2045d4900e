#include "sim/score/absolute_metrics.h"

#include <fmt/format.h>

#include <cmath>

#include "sim/score/alignment.h"
#include "sim/score/errors.h"
#include "sim/score/scored.h"

namespace sim::score {
namespace {

using enum Worst;
using S = const Scored&;

std::string unaligned(const std::string& what) {
  return fmt::format(
      "{}, without alignment: both poses are in W, the plan's world at t = 0. Frames count from the first "
      "planned motion on, when the planned waist is more than 1 mm from its start.",
      what);
}

Value ate(const Scored& s, Alignment alignment) {
  const auto found = align(s.pairs, alignment);
  if (const auto* none = std::get_if<NoAlignment>(&found)) return Value::none(none->reason);
  return root_mean_square(position_errors(transformed(std::get<Similarity>(found), s.pairs)));
}

Value scale_error(const Scored& s) {
  const auto found = align(s.pairs, Alignment::sim3);
  if (const auto* none = std::get_if<NoAlignment>(&found)) return Value::none(none->reason);
  return 100 * (1 / std::get<Similarity>(found).scale - 1);
}

double error_along(const PosePair& pair, int axis) {
  return pair.X_estimate.translation()(axis) - pair.X_true.translation()(axis);
}

template <typename Error>
double rmse(const Scored& s, Error error) {
  std::vector<double> errors;
  for (const PosePair& pair : s.pairs) errors.push_back(error(pair));
  return root_mean_square(errors);
}

double end_distance(const Scored& s) { return position_errors({s.pairs.back()}).front(); }

Value drift_percent(const Scored& s) {
  const double walked = path_length(s.truth_camera);
  if (walked <= 0) return Value::none("the true camera never moves");
  return 100 * end_distance(s) / walked;
}

MetricDefinition ate_metric(const std::string& name, const std::string& alignment, Needs needs, Alignment how,
                            bool headline = false) {
  return {"ate_" + name + "_rmse_m",
          "m",
          "Absolute trajectory error: root mean square distance between estimated and true camera positions, "
          "the estimate aligned by " +
              alignment + ". Frames count from the first planned motion on.",
          needs,
          [how](S s) { return ate(s, how); },
          largest,
          headline};
}

}  // namespace

MetricDefinitions absolute_metrics() {
  MetricDefinitions all{
      ate_metric("se3", "the rotation and translation of least squares (SE(3))", Needs::scale, Alignment::se3,
                 kHeadline),
      {"rmse_m", "m", unaligned("Root mean square distance between estimated and true camera positions"),
       Needs::scale, [](S s) { return ate(s, Alignment::none); }, largest, kHeadline},
      ate_metric("yaw", "the rotation about the vertical and the translation of least squares", Needs::scale,
                 Alignment::yaw_position),
      ate_metric("sim3", "the rotation, translation and scale of least squares (Sim(3))", Needs::estimate,
                 Alignment::sim3),
      ate_metric("origin", "moving the first estimated pose onto the first true one", Needs::scale,
                 Alignment::origin),
      ate_metric("scale", "the scale of ate_sim3_rmse_m alone, without its rotation and translation",
                 Needs::estimate, Alignment::scale),
      {"scale_error_percent", "%",
       "By how much the estimated path is too large, by the scale of the alignment of ate_sim3_rmse_m.",
       Needs::scale, scale_error, largest_magnitude, kHeadline},
      {"poses_matched", "1",
       "Number of estimated poses that have the stamp of a true one, from the first planned motion on: the "
       "errors are taken over these.",
       Needs::estimate, [](S s) { return static_cast<double>(s.pairs.size()); }, smallest}};
  for (int axis = 0; axis < 3; ++axis)
    all.push_back(
        {fmt::format("rmse_{}_m", "xyz"[axis]), "m",
         unaligned(fmt::format("Root mean square of the camera's position error along {} of W", "xyz"[axis])),
         Needs::scale,
         [axis](S s) { return rmse(s, [axis](const PosePair& pair) { return error_along(pair, axis); }); }});
  all.push_back({"rotation_rmse_deg", "deg",
                 unaligned("Root mean square angle between estimated and true camera orientations"),
                 Needs::estimate,
                 [](S s) { return root_mean_square(orientation_errors(s.pairs)) / kDegree; }});
  all.push_back({"yaw_rmse_deg", "deg",
                 unaligned("Root mean square of the rotation about the vertical that brings the estimated "
                           "camera orientation nearest to the true one"),
                 Needs::estimate, [](S s) {
                   return rmse(s, [](const PosePair& pair) { return yaw_error(pair) / kDegree; });
                 }});
  return all;
}

MetricDefinitions end_metrics() {
  MetricDefinitions all{
      {"end_position_error_m", "m",
       "Distance between estimated and true camera positions at the last frame, without alignment.",
       Needs::scale, end_distance, largest, kHeadline}};
  for (int axis = 0; axis < 3; ++axis)
    all.push_back(
        {fmt::format("end_error_{}_m", "xyz"[axis]), "m",
         fmt::format(
             "Estimated minus true camera position at the last frame along {} of W, without alignment.",
             "xyz"[axis]),
         Needs::scale, [axis](S s) { return error_along(s.pairs.back(), axis); }, largest_magnitude});
  all.push_back({"drift_percent", "%", "end_position_error_m in percent of path_length_m.", Needs::scale,
                 drift_percent, largest, kHeadline});
  all.push_back({"end_yaw_error_deg", "deg",
                 "Magnitude of the rotation about the vertical that brings the estimated camera orientation "
                 "nearest to the true one at the last frame, without alignment.",
                 Needs::estimate, [](S s) { return std::abs(yaw_error(s.pairs.back())) / kDegree; }, largest,
                 kHeadline});
  return all;
}

}  // namespace sim::score
