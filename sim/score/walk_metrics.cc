#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/score/metrics.h"
#include "sim/score/score_context.h"

namespace sim::score {
namespace {

using enum Worst;
using C = const ScoreContext&;

// of(the true camera from the first planned motion on)
template <typename F>
Value of_true_path(C c, F of) {
  if (c.truth_camera.empty()) return Absent{"the plan never moves"};
  return of(c.truth_camera);
}

Value plan_rmse(C c) {
  const std::vector<PosePair> pairs = pair_by_stamp(c.truth_camera, c.run.plan_camera);
  if (pairs.empty())
    return Absent{"no planned camera pose from the first motion on has the stamp of a true one"};
  return root_mean_square(position_errors(pairs));
}

MetricDefinition plan_drift(const std::string& name, const std::string& unit, const std::string& definition,
                            double Drift::*part, double per_unit = 1) {
  const auto compute = [part, per_unit](C c) -> Value {
    const std::vector<PosePair> pairs = pair_by_stamp(c.run.truth_waist, c.run.plan_waist);
    if (pairs.empty()) return Absent{"no planned waist pose has the stamp of a true one"};
    return drift(pairs.back().X_true, pairs.back().X_estimate, c.run.plan_waist.front().X).*part / per_unit;
  };
  return {name, unit, definition, Needs::walk, compute, largest_magnitude, kHeadline, kAtEnd};
}

// 1 also if the plan ends before another frame.
Value track_completion(C c) {
  if (!c.run.estimate) return Absent{"the filter was not run"};
  if (c.run.estimate->empty()) return Absent{"the filter gave no estimate"};
  if (!c.run.planned || c.run.planned->end.count() <= 0)
    return Absent{"the duration of the plan is not known"};
  const Trajectory& frames = c.run.truth_camera;
  const Stamp interval = frames.size() > 1 ? frames[1].t - frames[0].t : Stamp(0), end = c.run.planned->end,
              last = c.run.estimate->back().t;
  return last + interval > end ? 1.0 : static_cast<double>(last.count()) / static_cast<double>(end.count());
}

// The fraction of the time between the first and the last observation with a flag set. An interval
// has the state after the observation that ends it; late observations are not counted.
Value fraction_of_time(C c, bool TimedHealth::*flag) {
  if (!c.run.estimate) return Absent{"the filter was not run"};
  if (c.run.health.empty()) return Absent{"no observation reached the filter"};
  Stamp last = c.run.health.front().t, set{0};
  for (const TimedHealth& now : c.run.health) {
    if (now.t <= last) continue;
    if (now.*flag) set += now.t - last;
    last = now.t;
  }
  const Stamp all = last - c.run.health.front().t;
  if (all.count() == 0) return Absent{"the filter had fewer than two observations"};
  return static_cast<double>(set.count()) / static_cast<double>(all.count());
}

double ground_distance(const Eigen::Isometry3d& one, const Eigen::Isometry3d& two) {
  return (one.translation() - two.translation()).head<2>().norm();
}

template <typename F>
Value of_path(C c, F of) {
  if (!c.run.desired) return Absent{"no path was commanded"};
  if (c.run.truth_waist.empty()) return Absent{"the true waist is not known"};
  return of(*c.run.desired);
}

Value navigation_rmse(C c) {
  if (!c.start) return Absent{"the plan never moves"};
  return of_path(c, [&](const DesiredPath& path) -> Value {
    double sum = 0;
    int n = 0;
    for (const PosePair& pair : pair_by_stamp(c.run.truth_waist, path.waist)) {
      if (pair.t < *c.start) continue;
      const double distance = ground_distance(pair.X_true, pair.X_estimate);
      sum += distance * distance;
      ++n;
    }
    if (n == 0) return Absent{"no true waist pose has a stamp of the path"};
    return std::sqrt(sum / n);
  });
}

Value end_position(C c) {
  return of_path(c, [&](const DesiredPath& path) -> Value {
    return ground_distance(c.run.truth_waist.back().X, path.end);
  });
}

Value end_yaw(C c) {
  return of_path(c, [&](const DesiredPath& path) -> Value {
    const Eigen::Matrix3d turn = path.end.linear().transpose() * c.run.truth_waist.back().X.linear();
    return std::abs(yaw(turn)) / kDegree;
  });
}

Value lap_end(C c, bool first) {
  return of_path(c, [&](const DesiredPath& path) -> Value {
    if (path.laps.empty()) return Absent{"the walk has no laps: no command is repeated"};
    const Stamp end = (first ? path.laps.front() : path.laps.back()).second;
    if (c.run.truth_waist.back().t < end) return Absent{"the lap was not finished"};
    const auto truth = interpolate(c.run.truth_waist, end), wanted = interpolate(path.waist, end);
    if (!truth || !wanted) return Absent{"the true waist is not known at the end of the lap"};
    return ground_distance(*truth, *wanted);
  });
}

// sum(of(each correction))
template <typename F>
MetricDefinition correction_metric(const std::string& name, const std::string& unit,
                                   const std::string& definition, double (*of)(const StepCorrection&),
                                   F sum) {
  const auto compute = [of, sum](C c) -> Value {
    if (!c.run.steered) return Absent{"the walk was not steered"};
    if (c.run.corrections.empty()) return Absent{"no footstep could be corrected"};
    std::vector<double> all;
    for (const StepCorrection& correction : c.run.corrections) all.push_back(of(correction));
    return sum(all);
  };
  return {name, unit, definition, Needs::walk, compute, largest};
}

double length(const StepCorrection& s) { return std::hypot(s.ahead, s.aside); }
double turn_deg(const StepCorrection& s) { return std::abs(s.turn) / kDegree; }
double is_corrected(const StepCorrection& s) { return s.ahead != 0 || s.aside != 0 || s.turn != 0 ? 1 : 0; }
double sum_of(const std::vector<double>& all) { return std::accumulate(all.begin(), all.end(), 0.0); }
double greatest_of(const std::vector<double>& all) { return *std::max_element(all.begin(), all.end()); }

}  // namespace

MetricDefinitions walk_metrics() {
  const std::string end = " at the last frame";
  return {
      {"height_range_m", "m",
       "Greatest minus least estimated camera height from the first planned motion on.", Needs::scale,
       [](C c) { return height_range(c.estimate); }, largest, kHeadline},
      {"true_height_range_m", "m",
       "Greatest minus least true camera height from the first planned motion on.", Needs::walk,
       [](C c) { return of_true_path(c, height_range); }, largest, kHeadline},
      {"plan_rmse_m", "m", "Value of rmse_m for the planned camera pose instead of the estimate.",
       Needs::walk, plan_rmse, largest, kHeadline},
      plan_drift("plan_drift_x_m", "m",
                 "True minus planned waist position" + end + ", forward in axes of the planned start.",
                 &Drift::x),
      plan_drift("plan_drift_y_m", "m",
                 "True minus planned waist position" + end + ", to the left in axes of the planned start.",
                 &Drift::y),
      plan_drift("plan_drift_yaw_deg", "deg", "True minus planned waist yaw" + end + ", left positive.",
                 &Drift::yaw, kDegree)};
}

MetricDefinitions navigation_metrics() {
  const std::string distance = "Distance on the ground of the true waist ";
  return {
      {"navigation_rmse_m", "m",
       "Root mean square distance on the ground of the true waist from its place on the commanded path "
       "at that time, from the first planned motion on.",
       Needs::walk, navigation_rmse, largest, kHeadline},
      {"navigation_end_position_error_m", "m",
       distance + "at the last frame from the end of the commanded path.", Needs::walk, end_position, largest,
       kHeadline, kAtEnd},
      {"navigation_end_yaw_error_deg", "deg",
       "Angle between the true heading of the waist at the last frame and that at the end of the "
       "commanded path.",
       Needs::walk, end_yaw, largest, kHeadline, kAtEnd},
      {"navigation_first_lap_end_error_m", "m", distance + "from the commanded path when the first lap ends.",
       Needs::walk, [](C c) { return lap_end(c, true); }, largest},
      {"navigation_last_lap_end_error_m", "m", distance + "from the commanded path when the last lap ends.",
       Needs::walk, [](C c) { return lap_end(c, false); }, largest},
      correction_metric("steps_corrected", "1", "Number of footsteps that steering corrected.", is_corrected,
                        sum_of),
      correction_metric("correction_mean_m", "m",
                        "Mean correction of the footsteps that steering could correct.", length, mean),
      correction_metric("correction_largest_m", "m", "Largest correction of a footstep by steering.", length,
                        greatest_of),
      correction_metric("correction_largest_deg", "deg", "Largest turn of a footstep by steering.", turn_deg,
                        greatest_of)};
}

MetricDefinitions completion_metrics() {
  const std::string time = "Fraction of the time from the first observation to the last in which the filter ";
  return {{"path_length_m", "m",
           "Length of the true camera's path, from frame to frame, from the first planned motion on.",
           Needs::walk, [](C c) { return of_true_path(c, path_length); }, smallest, kHeadline},
          {"track_completion", "1",
           "Fraction of the plan's duration up to the last estimate. A filter that diverged gives none after "
           "that.",
           Needs::walk, track_completion, smallest, kHeadline},
          {"tracked_fraction", "1", time + "tracked: it was neither lost nor diverged.", Needs::walk,
           [](C c) { return fraction_of_time(c, &TimedHealth::tracks); }, smallest, kHeadline},
          {"fault_flag_fraction", "1", time + "reported that one sensor contradicts the others.", Needs::walk,
           [](C c) { return fraction_of_time(c, &TimedHealth::fault_flag); }, largest, kHeadline}};
}

}  // namespace sim::score
