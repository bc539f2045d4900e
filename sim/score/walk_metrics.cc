#include "sim/score/walk_metrics.h"

#include "sim/score/errors.h"
#include "sim/score/scored.h"

namespace sim::score {
namespace {

using enum Worst;
using S = const Scored&;

// of(the true camera from the first planned motion on).
template <typename F>
Value of_true_path(const Scored& s, F of) {
  if (s.truth_camera.empty()) return Value::none("the plan never moves");
  return of(s.truth_camera);
}

Value plan_rmse(const Scored& s) {
  const std::vector<PosePair> pairs = pair_by_stamp(s.truth_camera, s.run.plan_camera);
  if (pairs.empty())
    return Value::none("no planned camera pose from the first motion on has the stamp of a true one");
  return root_mean_square(position_errors(pairs));
}

template <typename Part>
Value plan_drift(const Scored& s, Part part) {
  const std::vector<PosePair> pairs = pair_by_stamp(s.run.truth_waist, s.run.plan_waist);
  if (pairs.empty()) return Value::none("no planned waist pose has the stamp of a true one");
  return part(drift(pairs.back().X_true, pairs.back().X_estimate, s.run.plan_waist.front().X));
}

// 1 also where the plan ends before another frame.
Value completion(const Scored& s, Stamp last) {
  if (!s.run.planned || s.run.planned->end.count() <= 0)
    return Value::none("how long the plan takes is not known");
  const Trajectory& frames = s.run.truth_camera;
  const Stamp interval = frames.size() > 1 ? frames[1].t - frames[0].t : Stamp(0), end = s.run.planned->end;
  return last + interval > end ? 1 : static_cast<double>(last.count()) / static_cast<double>(end.count());
}

Value walk_completion(const Scored& s) {
  if (s.run.truth_camera.empty()) return Value::none("there is no true pose");
  return completion(s, s.run.truth_camera.back().t);
}

Value track_completion(const Scored& s) {
  if (!s.run.estimate) return Value::none("the filter was not run");
  if (s.run.estimate->empty()) return Value::none("there is no estimate");
  return completion(s, s.run.estimate->back().t);
}

// The fraction of the time between the first and the last observation for which `holds` was true. An interval
// has the state after the observation that ends it; observations that come late are not counted.
Value share_of_time(const Scored& s, bool (*holds)(const TimedHealth&)) {
  if (!s.run.estimate) return Value::none("the filter was not run");
  if (s.run.health.empty()) return Value::none("no observation reached the filter");
  Stamp last = s.run.health.front().t, held{0};
  for (const TimedHealth& now : s.run.health) {
    if (now.t <= last) continue;
    if (holds(now)) held += now.t - last;
    last = now.t;
  }
  const Stamp all = last - s.run.health.front().t;
  if (all.count() == 0) return Value::none("the filter had fewer than two observations");
  return static_cast<double>(held.count()) / static_cast<double>(all.count());
}

}  // namespace

MetricDefinitions walk_metrics() {
  return {{"height_range_m", "m",
           "Greatest minus least estimated camera height from the first planned motion on.", Needs::scale,
           [](S s) { return height_range(s.estimate); }, largest, kHeadline},
          {"true_height_range_m", "m",
           "Greatest minus least true camera height from the first planned motion on.", Needs::walk,
           [](S s) { return of_true_path(s, height_range); }, largest, kHeadline},
          {"plan_rmse_m", "m", "What rmse_m would be if the planned camera pose were the estimate.",
           Needs::walk, plan_rmse, largest, kHeadline},
          {"plan_drift_x_m", "m",
           "True minus planned waist position at the last frame, forward in axes of the planned start.",
           Needs::walk, [](S s) { return plan_drift(s, [](const Drift& d) { return d.x; }); },
           largest_magnitude, kHeadline},
          {"plan_drift_y_m", "m",
           "True minus planned waist position at the last frame, to the left in axes of the planned start.",
           Needs::walk, [](S s) { return plan_drift(s, [](const Drift& d) { return d.y; }); },
           largest_magnitude, kHeadline},
          {"plan_drift_yaw_deg", "deg", "True minus planned waist yaw at the last frame, left positive.",
           Needs::walk, [](S s) { return plan_drift(s, [](const Drift& d) { return d.yaw / kDegree; }); },
           largest_magnitude, kHeadline}};
}

MetricDefinitions completion_metrics() {
  return {{"path_length_m", "m",
           "Length of the true camera's path, from frame to frame, from the first planned motion on.",
           Needs::walk, [](S s) { return of_true_path(s, path_length); }, smallest, kHeadline},
          {"walk_completion", "1", "Fraction of the plan's duration that was walked, up to the last frame.",
           Needs::walk, walk_completion, smallest},
          {"track_completion", "1",
           "Fraction of the plan's duration up to the last estimate; a filter that diverged gives none after "
           "that.",
           Needs::walk, track_completion, smallest, kHeadline},
          {"tracked_share", "1",
           "Fraction of the time from the first observation to the last in which the filter tracked: it was "
           "neither lost nor diverged.",
           Needs::walk,
           [](S s) { return share_of_time(s, [](const TimedHealth& h) { return h.tracks; }); }, smallest,
           kHeadline},
          {"suspect_share", "1",
           "Fraction of the time from the first observation to the last in which the filter found that a "
           "sensor contradicts the others.",
           Needs::walk,
           [](S s) { return share_of_time(s, [](const TimedHealth& h) { return h.suspects; }); }, largest,
           kHeadline}};
}

}  // namespace sim::score
