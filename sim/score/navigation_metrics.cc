#include "sim/score/navigation_metrics.h"

#include <algorithm>
#include <cmath>

#include "sim/score/scored.h"

namespace sim::score {
namespace {

using enum Worst;
using S = const Scored&;

double on_the_ground(const Eigen::Isometry3d& one, const Eigen::Isometry3d& two) {
  return (one.translation() - two.translation()).head<2>().norm();
}

/// Root mean square distance on the ground from `begin` up to `end`.
Value distance_from_path(const Scored& s, Stamp begin, Stamp end) {
  double sum = 0;
  int n = 0;
  for (const PosePair& pair : pair_by_stamp(s.run.truth_waist, s.run.desired->waist)) {
    if (pair.t < begin || pair.t > end) continue;
    const double distance = on_the_ground(pair.X_true, pair.X_estimate);
    sum += distance * distance;
    ++n;
  }
  if (n == 0) return Value::none("no true waist pose is of that time");
  return std::sqrt(sum / n);
}

template <typename F>
Value of_path(const Scored& s, F of) {
  if (!s.run.desired) return Value::none("no path was commanded");
  if (s.run.truth_waist.empty()) return Value::none("there is no true waist pose");
  return of(*s.run.desired);
}

Value navigation_rmse(const Scored& s) {
  if (!s.begin) return Value::none("the plan never moves");
  return of_path(s, [&](const DesiredPath&) { return distance_from_path(s, *s.begin, Stamp::max()); });
}

Value end_position(const Scored& s) {
  return of_path(s, [&](const DesiredPath& path) -> Value {
    return on_the_ground(s.run.truth_waist.back().X, path.end);
  });
}

Value end_yaw(const Scored& s) {
  return of_path(s, [&](const DesiredPath& path) -> Value {
    const Eigen::Matrix3d turn = path.end.linear().transpose() * s.run.truth_waist.back().X.linear();
    return std::abs(yaw(turn)) / kDegree;
  });
}

enum class Lap { first, last };

template <typename F>
Value of_lap(const Scored& s, Lap which, F of) {
  return of_path(s, [&](const DesiredPath& path) -> Value {
    if (path.laps.empty()) return Value::none("the walk has no laps: no command is repeated");
    const auto [begin, end] = which == Lap::first ? path.laps.front() : path.laps.back();
    if (s.run.truth_waist.back().t < end) return Value::none("the lap was not finished");
    return of(path, begin, end);
  });
}

Value lap_rmse(const Scored& s, Lap which) {
  return of_lap(s, which, [&](const DesiredPath&, Stamp begin, Stamp end) {
    return distance_from_path(s, begin, end);
  });
}

Value lap_end(const Scored& s, Lap which) {
  return of_lap(s, which, [&](const DesiredPath& path, Stamp, Stamp end) -> Value {
    const auto truth = interpolate(s.run.truth_waist, end), wanted = interpolate(path.waist, end);
    if (!truth || !wanted) return Value::none("no true waist pose is of the lap's end");
    return on_the_ground(*truth, *wanted);
  });
}

template <typename F>
Value of_corrections(const Scored& s, F of) {
  if (!s.run.steered) return Value::none("the walk was not steered");
  if (s.run.corrections.empty()) return Value::none("no footstep could be corrected");
  return of(s.run.corrections);
}

double distance(const StepCorrection& c) { return std::hypot(c.ahead, c.aside); }

Value steps_corrected(const Scored& s) {
  return of_corrections(s, [](const auto& all) -> Value {
    return static_cast<double>(std::count_if(all.begin(), all.end(), [](const StepCorrection& c) {
      return c.ahead != 0 || c.aside != 0 || c.turn != 0;
    }));
  });
}

Value mean_correction(const Scored& s) {
  return of_corrections(s, [](const auto& all) -> Value {
    double sum = 0;
    for (const StepCorrection& c : all) sum += distance(c);
    return sum / static_cast<double>(all.size());
  });
}

Value largest_correction(const Scored& s) {
  return of_corrections(s, [](const auto& all) -> Value {
    double most = 0;
    for (const StepCorrection& c : all) most = std::max(most, distance(c));
    return most;
  });
}

Value largest_turn(const Scored& s) {
  return of_corrections(s, [](const auto& all) -> Value {
    double most = 0;
    for (const StepCorrection& c : all) most = std::max(most, std::abs(c.turn) / kDegree);
    return most;
  });
}

MetricDefinitions lap_metrics() {
  return {{"navigation_first_lap_rmse_m", "m",
           "Root mean square distance on the ground of the true waist from the commanded path in the first "
           "lap of a repeat.",
           Needs::walk, [](S s) { return lap_rmse(s, Lap::first); }, largest},
          {"navigation_last_lap_rmse_m", "m",
           "Root mean square distance on the ground of the true waist from the commanded path in the last "
           "lap of a repeat.",
           Needs::walk, [](S s) { return lap_rmse(s, Lap::last); }, largest},
          {"navigation_first_lap_end_error_m", "m",
           "Distance on the ground of the true waist from the commanded path when the first lap ends.",
           Needs::walk, [](S s) { return lap_end(s, Lap::first); }, largest},
          {"navigation_last_lap_end_error_m", "m",
           "Distance on the ground of the true waist from the commanded path when the last lap ends.",
           Needs::walk, [](S s) { return lap_end(s, Lap::last); }, largest}};
}

MetricDefinitions correction_metrics() {
  return {
      {"steps_corrected", "1", "Number of footsteps that steering corrected.", Needs::walk, steps_corrected,
       largest},
      {"correction_mean_m", "m", "Mean distance by which steering moved a footstep that it could correct.",
       Needs::walk, mean_correction, largest},
      {"correction_largest_m", "m", "Largest distance by which steering moved a footstep.", Needs::walk,
       largest_correction, largest},
      {"correction_largest_deg", "deg", "Largest angle by which steering turned a footstep.", Needs::walk,
       largest_turn, largest}};
}

}  // namespace

MetricDefinitions navigation_metrics() {
  MetricDefinitions all{
      {"navigation_rmse_m", "m",
       "Root mean square distance on the ground of the true waist from where the commanded path wants it at "
       "that time, from the first planned motion on.",
       Needs::walk, navigation_rmse, largest, kHeadline},
      {"navigation_end_position_error_m", "m",
       "Distance on the ground of the true waist at the last frame from the end of the commanded path.",
       Needs::walk, end_position, largest, kHeadline},
      {"navigation_end_yaw_error_deg", "deg",
       "Angle between the true heading of the waist at the last frame and that at the end of the commanded "
       "path.",
       Needs::walk, end_yaw, largest, kHeadline}};
  for (const auto group : {lap_metrics, correction_metrics})
    for (MetricDefinition& definition : group()) all.push_back(std::move(definition));
  return all;
}

}  // namespace sim::score
