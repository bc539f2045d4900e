#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/score/metrics.h"
#include "sim/score/run.h"

namespace sim::score {
namespace {

using enum Worst;
using C = const ScoreContext&;
using Numbers = std::vector<double>;

// of(the true camera from the first planned motion on)
auto of_true_path(double (*of)(const Trajectory&)) {
  return [of](C c) -> Value {
    if (c.truth_camera.empty()) return Absent{"the plan never moves"};
    return of(c.truth_camera);
  };
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
  const std::string text = "True minus planned waist " + definition;
  return {"plan_drift_" + name, unit, text, Needs::walk, compute, largest_magnitude, kHeadline, kAtEnd};
}

// 1 also if the plan ends before another frame.
Value track_completion(C c) {
  if (!c.run.estimate) return Absent{"the filter was not run"};
  if (c.run.estimate->empty()) return Absent{"the estimator gave no estimate"};
  const Stamp end = c.run.plan_end.value_or(Stamp(0)), last = c.run.estimate->back().t;
  if (end.count() <= 0) return Absent{"the duration of the plan is not known"};
  const Trajectory& frames = c.run.truth_camera;
  const Stamp interval = frames.size() > 1 ? frames[1].t - frames[0].t : Stamp(0);
  return last + interval > end ? 1.0 : static_cast<double>(last.count()) / static_cast<double>(end.count());
}

// The fraction of the time between the first and the last observation with a flag set. An interval
// has the state after the observation that ends it; late observations are not counted.
auto fraction_of_time(bool TimedHealth::*flag) {
  return [flag](C c) -> Value {
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
  };
}

double ground_distance(const Eigen::Isometry3d& one, const Eigen::Isometry3d& two) {
  return (one.translation() - two.translation()).head<2>().norm();
}

// of(the context, the commanded path)
auto of_path(Value (*of)(C, const DesiredPath&)) {
  return [of](C c) -> Value {
    if (!c.run.desired) return Absent{"no path was commanded"};
    if (c.run.truth_waist.empty()) return Absent{"the true waist is not known"};
    return of(c, *c.run.desired);
  };
}

Value navigation_rmse(C c, const DesiredPath& path) {
  if (!c.start) return Absent{"the plan never moves"};
  Numbers distances;
  for (const PosePair& pair : pair_by_stamp(c.run.truth_waist, path.waist))
    if (pair.t >= *c.start) distances.push_back(ground_distance(pair.X_true, pair.X_estimate));
  if (distances.empty()) return Absent{"no true waist pose has a stamp of the path"};
  return root_mean_square(distances);
}

Value end_position(C c, const DesiredPath& path) {
  return ground_distance(c.run.truth_waist.back().X, path.end);
}

Value end_yaw(C c, const DesiredPath& path) {
  const Eigen::Matrix3d turn = path.end.linear().transpose() * c.run.truth_waist.back().X.linear();
  return std::abs(yaw(turn)) / kDegree;
}

Value lap_end(C c, const DesiredPath& path, bool first) {
  if (path.laps.empty()) return Absent{"the walk has no laps: no command is repeated"};
  const Stamp end = (first ? path.laps.front() : path.laps.back()).second;
  if (c.run.truth_waist.back().t < end) return Absent{"the lap was not finished"};
  const auto truth = interpolate(c.run.truth_waist, end), wanted = interpolate(path.waist, end);
  if (!truth || !wanted) return Absent{"the true waist is not known at the end of the lap"};
  return ground_distance(*truth, *wanted);
}

// combined(of(each correction))
auto of_corrections(double (*of)(const StepCorrection&), double (*combined)(const Numbers&)) {
  return [of, combined](C c) -> Value {
    if (!c.run.steered) return Absent{"the walk was not steered"};
    if (c.run.corrections.empty()) return Absent{"no footstep could be corrected"};
    Numbers all;
    for (const StepCorrection& correction : c.run.corrections) all.push_back(of(correction));
    return combined(all);
  };
}

double length(const StepCorrection& s) { return std::hypot(s.ahead, s.aside); }
double turn_deg(const StepCorrection& s) { return std::abs(s.turn) / kDegree; }
double is_corrected(const StepCorrection& s) { return s.ahead != 0 || s.aside != 0 || s.turn != 0 ? 1 : 0; }
double sum_of(const Numbers& all) { return std::accumulate(all.begin(), all.end(), 0.0); }
double greatest_of(const Numbers& all) { return *std::max_element(all.begin(), all.end()); }

}  // namespace

MetricDefinitions walk_metrics() {
  const std::string distance = "Distance on the ground of the true waist ";
  return {
      {"height_range_m", "m",
       "Greatest minus least estimated camera height from the first planned motion on.", Needs::scale,
       [](C c) { return height_range(c.estimate); }, largest, kHeadline},
      {"true_height_range_m", "m",
       "Greatest minus least true camera height from the first planned motion on.", Needs::walk,
       of_true_path(height_range), largest, kHeadline},
      {"plan_rmse_m", "m", "Value of rmse_m for the planned camera pose instead of the estimate.",
       Needs::walk, plan_rmse, largest, kHeadline},
      plan_drift("x_m", "m", "position at the last frame, forward in axes of the planned start.", &Drift::x),
      plan_drift("y_m", "m", "position at the last frame, to the left in axes of the planned start.",
                 &Drift::y),
      plan_drift("yaw_deg", "deg", "yaw at the last frame, left positive.", &Drift::yaw, kDegree),
      {"navigation_rmse_m", "m",
       "Root mean square distance on the ground of the true waist from its place on the commanded path "
       "at that time, from the first planned motion on.",
       Needs::walk, of_path(navigation_rmse), largest, kHeadline},
      {"navigation_end_position_error_m", "m",
       distance + "at the last frame from the end of the commanded path.", Needs::walk, of_path(end_position),
       largest, kHeadline, kAtEnd},
      {"navigation_end_yaw_error_deg", "deg",
       "Angle between the true heading of the waist at the last frame and that at the end of the "
       "commanded path.",
       Needs::walk, of_path(end_yaw), largest, kHeadline, kAtEnd},
      {"navigation_first_lap_end_error_m", "m", distance + "from the commanded path when the first lap ends.",
       Needs::walk, of_path([](C c, const DesiredPath& path) { return lap_end(c, path, true); })},
      {"navigation_last_lap_end_error_m", "m", distance + "from the commanded path when the last lap ends.",
       Needs::walk, of_path([](C c, const DesiredPath& path) { return lap_end(c, path, false); })},
      {"steps_corrected", "1", "Number of footsteps that steering corrected.", Needs::walk,
       of_corrections(is_corrected, sum_of)},
      {"correction_largest_m", "m", "Largest correction of a footstep by steering.", Needs::walk,
       of_corrections(length, greatest_of)},
      {"correction_largest_deg", "deg", "Largest turn of a footstep by steering.", Needs::walk,
       of_corrections(turn_deg, greatest_of)}};
}

MetricDefinitions completion_metrics() {
  const std::string time = "Fraction of the time from the first observation to the last in which the filter ";
  return {{"path_length_m", "m",
           "Length of the true camera's path, from frame to frame, from the first planned motion on.",
           Needs::walk, of_true_path(path_length), smallest, kHeadline},
          {"track_completion", "1",
           "Fraction of the plan's duration up to the last estimate. A filter that diverged gives none after "
           "that.",
           Needs::walk, track_completion, smallest, kHeadline},
          {"tracked_fraction", "1", time + "tracked: it was neither lost nor diverged.", Needs::walk,
           fraction_of_time(&TimedHealth::tracks), smallest, kHeadline},
          {"fault_flag_fraction", "1", time + "reported that one sensor contradicts the others.", Needs::walk,
           fraction_of_time(&TimedHealth::fault_flag), largest, kHeadline}};
}

}  // namespace sim::score
