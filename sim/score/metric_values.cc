#include "sim/score/metric_values.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/score/errors.h"
#include "sim/score/statistics.h"

namespace sim::score {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// value(similarity), if there is one that aligns the estimate.
template <typename F>
Value of_aligned(const Scored& s, Alignment alignment, F value) {
  return of_estimate(s, [&]() -> Value {
    const auto S = align(s.pairs, alignment);
    if (const auto* none = std::get_if<NoAlignment>(&S)) return Value::none(none->reason);
    return value(std::get<Similarity>(S));
  });
}

double end_distance(const Scored& s) { return position_errors({s.pairs.back()}).front(); }

// The root mean square of a part of the relative errors over the spans.
template <typename Part>
Value relative(const Scored& s, const std::vector<Span>& over, Part part) {
  std::vector<double> errors;
  for (const RelativeError& error : relative_errors(s.pairs, over)) errors.push_back(part(error));
  if (errors.empty()) return Value::none("the true path has no such spans");
  return root_mean_square(errors);
}

double translation(const RelativeError& error) { return error.translation; }
double degrees(const RelativeError& error) { return error.rotation / kDegree; }

template <typename Part>
Value over_steps(const Scored& s, Part part) {
  return of_estimate(s, [&]() -> Value {
    if (!s.run.planned) return Value::none("the planned footsteps are not known");
    std::vector<Stamp> walked;
    for (const Stamp t : s.run.planned->footsteps)
      if (t >= s.pairs.front().t && t <= s.pairs.back().t) walked.push_back(t);
    return relative(s, spans_between(s.pairs, walked), part);
  });
}

// 1 also where there is no room for another frame.
Value completion(const Scored& s, Stamp last) {
  if (!s.run.planned || s.run.planned->end.count() <= 0)
    return Value::none("how long the plan takes is not known");
  const Trajectory& frames = s.run.truth_camera;
  const Stamp interval = frames.size() > 1 ? frames[1].t - frames[0].t : Stamp(0), end = s.run.planned->end;
  return last + interval > end ? 1 : static_cast<double>(last.count()) / static_cast<double>(end.count());
}

template <typename Part>
Value plan_drift(const Scored& s, Part part) {
  const std::vector<PosePair> pairs = pair_by_stamp(s.run.truth_waist, s.run.plan_waist);
  if (pairs.empty()) return Value::none("no planned waist pose has the stamp of a true one");
  return part(drift(pairs.back().X_true, pairs.back().X_estimate, s.run.plan_waist.front().X));
}

}  // namespace

Value Value::none(std::string why) {
  Value v(0);
  v.value.reset();
  v.reason = std::move(why);
  return v;
}

Value ate(const Scored& s, Alignment alignment) {
  return of_aligned(s, alignment, [&](const Similarity& S) -> Value {
    return root_mean_square(position_errors(transformed(S, s.pairs)));
  });
}

Value scale_error(const Scored& s) {
  return of_aligned(s, Alignment::sim3, [](const Similarity& S) -> Value { return 100 * (1 / S.scale - 1); });
}

Value poses_matched(const Scored& s) {
  return of_estimate(s, [&]() -> Value { return static_cast<double>(s.pairs.size()); });
}

Value rmse_along(const Scored& s, int axis) {
  return of_estimate(s, [&]() -> Value {
    std::vector<double> errors;
    for (const PosePair& pair : s.pairs)
      errors.push_back(pair.X_estimate.translation()(axis) - pair.X_true.translation()(axis));
    return root_mean_square(errors);
  });
}

Value rotation_rmse(const Scored& s) {
  return of_estimate(s, [&]() -> Value { return root_mean_square(orientation_errors(s.pairs)) / kDegree; });
}

Value yaw_rmse(const Scored& s) {
  return of_estimate(s, [&]() -> Value {
    std::vector<double> errors;
    for (const PosePair& pair : s.pairs) errors.push_back(yaw_error(pair) / kDegree);
    return root_mean_square(errors);
  });
}

Value relative_translation(const Scored& s, const Spans& over) {
  return of_estimate(s, [&] { return relative(s, spans(s.pairs, over), translation); });
}
Value relative_rotation(const Scored& s, const Spans& over) {
  return of_estimate(s, [&] { return relative(s, spans(s.pairs, over), degrees); });
}
Value step_translation(const Scored& s) { return over_steps(s, translation); }
Value step_rotation(const Scored& s) { return over_steps(s, degrees); }

Value walk_completion(const Scored& s) {
  if (s.run.truth_camera.empty()) return Value::none("there is no true pose");
  return completion(s, s.run.truth_camera.back().t);
}

Value track_completion(const Scored& s) {
  if (!s.run.estimate) return Value::none("the filter was not run");
  if (s.run.estimate->empty()) return Value::none("there is no estimate");
  return completion(s, s.run.estimate->back().t);
}

Value end_position_error(const Scored& s) {
  return of_estimate(s, [&]() -> Value { return end_distance(s); });
}

Value end_error_along(const Scored& s, int axis) {
  return of_estimate(s, [&]() -> Value {
    const PosePair& end = s.pairs.back();
    return end.X_estimate.translation()(axis) - end.X_true.translation()(axis);
  });
}

Value drift_percent(const Scored& s) {
  return of_estimate(s, [&]() -> Value {
    const double walked = path_length(s.truth_camera);
    if (walked <= 0) return Value::none("the true camera never moves");
    return 100 * end_distance(s) / walked;
  });
}

Value end_yaw_error(const Scored& s) {
  return of_estimate(s, [&]() -> Value { return std::abs(yaw_error(s.pairs.back())) / kDegree; });
}

Value estimated_height_range(const Scored& s) {
  return of_estimate(s, [&]() -> Value { return height_range(s.estimate); });
}

Value true_height_range(const Scored& s) {
  if (s.truth_camera.empty()) return Value::none("the plan never moves");
  return height_range(s.truth_camera);
}

Value true_path_length(const Scored& s) {
  if (s.truth_camera.empty()) return Value::none("the plan never moves");
  return path_length(s.truth_camera);
}

Value plan_rmse(const Scored& s) {
  const std::vector<PosePair> pairs = pair_by_stamp(s.truth_camera, s.run.plan_camera);
  if (pairs.empty())
    return Value::none("no planned camera pose from the first motion on has the stamp of a true one");
  return root_mean_square(position_errors(pairs));
}

Value plan_drift_x(const Scored& s) {
  return plan_drift(s, [](const Drift& d) { return d.x; });
}
Value plan_drift_y(const Scored& s) {
  return plan_drift(s, [](const Drift& d) { return d.y; });
}
Value plan_drift_yaw(const Scored& s) {
  return plan_drift(s, [](const Drift& d) { return d.yaw / kDegree; });
}

}  // namespace sim::score
