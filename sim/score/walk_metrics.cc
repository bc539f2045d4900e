#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <unsupported/Eigen/FFT>

#include "sim/score/metrics.h"
#include "sim/score/run.h"

namespace sim::score {
namespace {

using enum Worst;
using C = const ScoreContext&;
using Numbers = std::vector<double>;
using Loop = std::vector<LoopLandmark>;

Value landmark_count(C c) {
  return value_of(c.loop, [](const Loop& loop) -> Value { return double(loop.size()); });
}

const PosePair* last_until(C c, Stamp t) {
  const auto last =
      std::find_if(c.pairs.rbegin(), c.pairs.rend(), [t](const PosePair& pair) { return pair.t <= t; });
  return last == c.pairs.rend() ? nullptr : &*last;
}

// The first landmark found again, and the errors (m) of the last positions before that and up to 1 s after.
struct Closure {
  double time_s = 0, error_before = 0, error_after = 0;
};

OrAbsent<Closure> closure(C c) {
  if (const auto* absent = std::get_if<Absent>(&c.loop)) return *absent;
  const Loop& loop = std::get<Loop>(c.loop);
  if (loop.size() < kLandmarksOfLoop)
    return Absent{
        fmt::format("{} landmarks were found again; {} close a loop", loop.size(), kLandmarksOfLoop)};
  const Stamp found = loop.front().found;
  const PosePair *before = last_until(c, found - Stamp(1)),
                 *after = last_until(c, found + std::chrono::seconds(1));
  if (!before || !after) return Absent{"no estimate before the closure"};
  return Closure{double(found.count()) * 1e-9, position_errors({*before}).front(),
                 position_errors({*after}).front()};
}

auto of_closure(double Closure::*part) {
  return [part](C c) {
    return value_of(closure(c), [part](const Closure& found) -> Value { return found.*part; });
  };
}

// Returns of(the true camera from the first planned motion).
auto of_true_path(double (*of)(const Trajectory&)) {
  return [of](C c) -> Value {
    if (c.truth_camera.empty()) return Absent{"the plan never moves"};
    return of(c.truth_camera);
  };
}

Value of_plan(const Trajectory& truth, const Trajectory& plan, auto of_pairs) {
  if (plan.empty()) return Absent{"the walk has no plan"};
  const std::vector<PosePair> pairs = pair_by_stamp(truth, plan);
  if (pairs.empty()) return Absent{"no planned pose since the first motion has the stamp of a true pose"};
  return of_pairs(pairs);
}

Value plan_rmse(C c) {
  return of_plan(c.truth_camera, c.run.plan_camera,
                 [](const auto& pairs) { return root_mean_square(position_errors(pairs)); });
}

MetricDefinition plan_drift(const std::string& name, const std::string& unit, const std::string& definition,
                            int part, double per_unit = 1) {
  const auto compute = [part, per_unit](C c) {
    return of_plan(c.run.truth_waist, c.run.plan_waist, [&](const auto& pairs) {
      return drift(pairs.back().X_true, pairs.back().X_estimate, c.run.plan_waist.front().X)[part] / per_unit;
    });
  };
  const std::string text = "True minus planned waist " + definition;
  return {"plan_drift_" + name, unit, text, Needs::walk, compute, largest_magnitude, kHeadline, Note::at_end};
}

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// By Parseval's theorem, for the axes together.
Value vibration_in_band(C c, double from_hz, double below_hz) {
  std::vector<Eigen::Vector3d> f;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const TrueForce& force : c.run.forces)
    if (c.start && force.t >= *c.start) f.push_back(force.f), mean += force.f;
  if (f.size() < 2) return Absent{"the run has no readings of an ideal IMU"};
  mean /= double(f.size());
  const double period_s = 1e-9 * double((c.run.forces[1].t - c.run.forces[0].t).count());
  const std::size_t n = std::bit_ceil(f.size());
  Eigen::FFT<double> fft;
  double squares = 0;
  for (int axis = 0; axis < 3; ++axis) {
    Numbers values(n, 0);
    for (std::size_t i = 0; i < f.size(); ++i) values[i] = f[i][axis] - mean[axis];
    std::vector<std::complex<double>> spectrum;
    fft.fwd(spectrum, values);
    for (std::size_t i = 0; i < n; ++i) {
      const double hz = double(std::min(i, n - i)) / (double(n) * period_s);
      if (hz >= from_hz && hz < below_hz) squares += std::norm(spectrum[i]);
    }
  }
  return std::sqrt(squares / double(n * f.size()));
}

// It is also 1 if the plan ends before another frame.
Value track_completion(C c) {
  if (!c.run.estimate) return Absent{"the estimator was not run"};
  if (c.run.estimate->empty()) return Absent{"the estimator gave no estimate"};
  const Stamp end = c.run.plan_end.value_or(Stamp(0)), last = c.run.estimate->back().t;
  if (end.count() <= 0) return Absent{"the walk has no plan"};
  const Trajectory& frames = c.run.truth_camera;
  const Stamp interval = frames.size() > 1 ? frames[1].t - frames[0].t : Stamp(0);
  return last + interval > end ? 1.0 : double(last.count()) / double(end.count());
}

// Returns the fraction of the time between the first and the last observation during which a flag is set. An
// interval has the flag set after the observation that ends it. Late observations are not counted.
auto fraction_of_time(bool TimedHealth::*flag) {
  return [flag](C c) -> Value {
    if (!c.run.estimate) return Absent{"the estimator was not run"};
    if (c.run.health.empty()) return Absent{"no observation reached the estimator"};
    Stamp last = c.run.health.front().t, set{0};
    for (const TimedHealth& now : c.run.health) {
      if (now.t <= last) continue;
      if (now.*flag) set += now.t - last;
      last = now.t;
    }
    const Stamp all = last - c.run.health.front().t;
    if (all.count() == 0) return Absent{"the estimator had fewer than two observations"};
    return double(set.count()) / double(all.count());
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
double greatest_of(const Numbers& all) { return *std::ranges::max_element(all); }

MetricDefinition timeliness(const std::string& name, const std::string& unit, const std::string& definition,
                            double (*of)(const Timeliness&)) {
  return {name, unit, definition, Needs::walk, [of](C c) -> Value {
            if (!c.run.estimate) return Absent{"the estimator was not run"};
            if (!c.run.timeliness)
              return Absent{"answers take no simulated time with estimator.time.model: none"};
            if (c.run.timeliness->took_ms.empty()) return Absent{"the estimator gave no answer"};
            return of(*c.run.timeliness);
          }};
}

double fraction_dropped(const Timeliness& t) {
  const auto dropped = double(t.dropped);
  return dropped / (dropped + double(t.took_ms.size()));
}

}  // namespace

MetricDefinitions loop_metrics() {
  const std::string position_error = "Error of the camera's position, without alignment, ";
  return {{"loop_landmarks", "1",
           "Number of landmarks that were found again after the camera had been elsewhere: they were out of "
           "the field of view for at least 5 s without interruption, at some moment together with "
           "everything seen in the last image before that, and were later matched within 3 px of the true "
           "projection of their "
           "surface point. Defined for walks that return to a landmark.",
           Needs::estimate, landmark_count, smallest, kHeadline},
          {"loop_closed", "1",
           fmt::format("1 if loop_landmarks is at least {}, otherwise 0.", kLandmarksOfLoop), Needs::estimate,
           [](C c) {
             return value_of(landmark_count(c), [](double count) -> Value {
               return count >= double(kLandmarksOfLoop) ? 1.0 : 0.0;
             });
           },
           smallest, kHeadline},
          {"loop_time_s", "s",
           "Time when the loop is closed: the first match of the first landmark of loop_landmarks, if it is "
           "closed.",
           Needs::estimate, of_closure(&Closure::time_s), largest, kHeadline},
          {"loop_error_before_m", "m", position_error + "in the frame before loop_time_s.", Needs::scale,
           of_closure(&Closure::error_before), largest, kHeadline},
          {"loop_error_after_m", "m",
           position_error + "1 s after loop_time_s, or at the last frame if that is earlier.", Needs::scale,
           of_closure(&Closure::error_after), largest, kHeadline}};
}

MetricDefinitions walk_metrics() {
  const std::string distance = "Distance on the ground of the true waist ";
  return {
      {"height_range_m", "m", "Largest minus smallest estimated camera height from the first planned motion.",
       Needs::scale, [](C c) { return height_range(c.estimate); }, largest, kHeadline},
      {"true_height_range_m", "m", "Largest minus smallest true camera height from the first planned motion.",
       Needs::walk, of_true_path(height_range), largest, kHeadline},
      {"plan_rmse_m", "m", "Value of rmse_m for the planned camera pose instead of the estimate.",
       Needs::walk, plan_rmse, largest, kHeadline},
      plan_drift("x_m", "m", "position at the last frame, forward in the planned start's axes.", 0),
      plan_drift("y_m", "m", "position at the last frame, to the left in the planned start's axes.", 1),
      plan_drift("yaw_deg", "deg", "yaw at the last frame, left positive.", 2, kDegree),
      {"navigation_rmse_m", "m",
       "Root mean square distance on the ground between the true waist and its place on the commanded path "
       "at that time, from the first planned motion. For an external controller, the path waits while the "
       "steered robot is more than 0.3 m or 0.5 rad away.",
       Needs::walk, of_path(navigation_rmse), largest, kHeadline},
      {"navigation_end_position_error_m", "m",
       distance + "at the last frame from the end of the commanded path.", Needs::walk,
       of_path([](C c, const DesiredPath& path) -> Value {
         return ground_distance(c.run.truth_waist.back().X, path.end);
       }),
       largest, kHeadline, Note::at_end},
      {"navigation_end_yaw_error_deg", "deg",
       "Angle between the true heading of the waist at the last frame and the heading at the end of the "
       "commanded path.",
       Needs::walk, of_path([](C c, const DesiredPath& path) -> Value {
         const Eigen::Matrix3d turn = path.end.linear().transpose() * c.run.truth_waist.back().X.linear();
         return std::abs(yaw(turn)) / kDegree;
       }),
       largest, kHeadline, Note::at_end},
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
  const std::string vibration =
      "Root mean square of the IMU's specific force without sensor errors, from the first planned motion, ";
  const std::string time = "Fraction of the time from the first observation to the last while the estimator ";
  return {{"path_length_m", "m",
           "Length of the true camera's path, from frame to frame, from the first planned motion.",
           Needs::walk, of_true_path(path_length), smallest, kHeadline},
          {"torque_limited_fraction", "1",
           "Fraction of the walk's 5 ms ticks with the torque of a leg's joint at its limit.", Needs::walk,
           [](C c) -> Value {
             if (!c.run.torque_limited) return Absent{"the robot has no torque limits"};
             return *c.run.torque_limited;
           },
           largest},
          {"vibration_below_2hz_m_s2", "m/s2", vibration + "minus its mean, at frequencies below 2 Hz.",
           Needs::walk, [](C c) { return vibration_in_band(c, 0, 2); }},
          {"vibration_2_to_8hz_m_s2", "m/s2", vibration + "at frequencies from 2 Hz to below 8 Hz.",
           Needs::walk, [](C c) { return vibration_in_band(c, 2, 8); }},
          {"vibration_from_8hz_m_s2", "m/s2", vibration + "at frequencies of 8 Hz and above.", Needs::walk,
           [](C c) { return vibration_in_band(c, 8, kInfinite); }},
          {"track_completion", "1",
           "Fraction of the plan's duration up to the last estimate. An estimator that diverged gives none "
           "after that.",
           Needs::walk, track_completion, smallest, kHeadline},
          {"tracked_fraction", "1",
           time + "tracked: it answered with a new pose, neither lost nor diverged. Dropped frames count as "
                  "not tracked.",
           Needs::walk, fraction_of_time(&TimedHealth::tracks), smallest, kHeadline},
          {"fault_flag_fraction", "1", time + "reported that one sensor contradicts the others.", Needs::walk,
           fraction_of_time(&TimedHealth::fault_flag), largest, kHeadline}};
}

MetricDefinitions timeliness_metrics() {
  using T = const Timeliness&;
  const std::string latency =
                        " of the simulated time from the stamp of a frame until its answer takes effect.",
                    budget = " of the simulated time of an answer, as a fraction of the time between frames.";
  return {
      timeliness("dropped_frames", "1", "Number of frames that were dropped because the estimator was busy.",
                 [](T t) { return double(t.dropped); }),
      timeliness("dropped_frames_fraction", "1", "Fraction of the frames that were dropped.",
                 fraction_dropped),
      timeliness("latency_median_ms", "ms", "Median" + latency, [](T t) { return median(t.latency_ms); }),
      timeliness("latency_p99_ms", "ms", "99th percentile" + latency,
                 [](T t) { return quantile(t.latency_ms, 0.99); }),
      timeliness("budget_fraction_mean", "1", "Mean" + budget,
                 [](T t) { return mean(t.took_ms) / t.period_ms; }),
      timeliness("budget_fraction_p99", "1", "99th percentile" + budget,
                 [](T t) { return quantile(t.took_ms, 0.99) / t.period_ms; })};
}

}  // namespace sim::score
