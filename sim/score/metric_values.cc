#include "sim/score/metric_values.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/score/alignment.h"
#include "sim/score/consistency.h"
#include "sim/score/errors.h"
#include "sim/score/relative.h"
#include "sim/score/statistics.h"

namespace sim::score {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// value(), if anything can be said of the estimate.
template <typename F>
Value of_estimate(const Scored& s, F value) {
  if (!s.no_estimate.empty()) return Value::none(s.no_estimate);
  return value();
}

// value(similarity), if there is one that aligns the estimate.
template <typename F>
Value of_aligned(const Scored& s, Alignment alignment, F value) {
  return of_estimate(s, [&]() -> Value {
    const auto S = align(s.pairs, alignment);
    if (const auto* none = std::get_if<NoAlignment>(&S)) return Value::none(none->reason);
    return value(std::get<Similarity>(S));
  });
}

Value ate(const Scored& s, Alignment alignment) {
  return of_aligned(s, alignment, [&](const Similarity& S) -> Value {
    return root_mean_square(position_errors(transformed(S, s.pairs)));
  });
}

double end_distance(const Scored& s) { return position_errors({s.pairs.back()}).front(); }

template <typename Part>
Value relative_1m(const Scored& s, Part part) {
  return of_estimate(s, [&]() -> Value {
    Spans metres{Spans::Unit::metres, 1, true};
    metres.along_truth = true;
    std::vector<double> errors;
    for (const RelativeError& error : relative_errors(s.pairs, spans(s.pairs, metres)))
      errors.push_back(part(error));
    if (errors.empty()) return Value::none("the true path has no spans of 1 m");
    return root_mean_square(errors);
  });
}

template <typename Part>
Value mean_nees(const Scored& s, Part part) {
  return of_estimate(s, [&]() -> Value {
    std::vector<double> values;
    for (const EstimatedPose& pose : *s.run.estimate)
      for (const PosePair& pair : pair_by_stamp(s.truth_camera, {{pose.t, pose.X_WC}})) {
        const auto nees = pose_nees(pair.X_true, pair.X_estimate, pose.covariance);
        if (!nees) return Value::none("a covariance of the estimate is not positive definite");
        values.push_back(part(*nees));
      }
    return mean(values);
  });
}

template <typename Part>
Value plan_drift(const Scored& s, Part part) {
  const std::vector<PosePair> pairs = pair_by_stamp(s.run.truth_waist, s.run.plan_waist);
  if (pairs.empty()) return Value::none("no planned waist pose has the stamp of a true one");
  return part(drift(pairs.back().X_true, pairs.back().X_estimate, s.run.plan_waist.front().X));
}

// part(what the feet did in a phase), if they were watched.
template <typename Part>
Value of_feet(const Scored& s, FootPhase phase, Part part) {
  if (s.run.feet.empty()) return Value::none("the feet were not recorded");
  return part(total(s.run.feet, phase));
}

// part summed over the phases in which a foot moves on the ground.
template <typename Part>
Value on_ground(const Scored& s, Part part) {
  if (s.run.feet.empty()) return Value::none("the feet were not recorded");
  double sum = 0;
  for (FootPhase phase : {FootPhase::landing, FootPhase::support, FootPhase::lift_off})
    sum += part(total(s.run.feet, phase));
  return sum;
}

constexpr auto kMoved = [](const FootTotal& t) { return t.moved; };
constexpr auto kTurned = [](const FootTotal& t) { return t.turned / kDegree; };
constexpr auto kDriftX = [](const FootTotal& t) { return t.drift.x; };
constexpr auto kDriftY = [](const FootTotal& t) { return t.drift.y; };
constexpr auto kDriftYaw = [](const FootTotal& t) { return t.drift.yaw / kDegree; };

// value(time of the first frame in which a landmark closed the loop), if there is one.
template <typename F>
Value of_closure(const Scored& s, F value) {
  if (!s.no_loop.empty()) return Value::none(s.no_loop);
  if (s.loop.empty()) return Value::none("no landmark closed the loop");
  const auto earlier = [](const LoopLandmark& a, const LoopLandmark& b) { return a.found < b.found; };
  return value(std::min_element(s.loop.begin(), s.loop.end(), earlier)->found);
}

// The position error of the last estimate not after t.
Value error_until(const Scored& s, Stamp t) {
  const auto last =
      std::find_if(s.pairs.rbegin(), s.pairs.rend(), [t](const PosePair& pair) { return pair.t <= t; });
  if (last == s.pairs.rend()) return Value::none("no estimate before the closure");
  return position_errors({*last}).front();
}

}  // namespace

Value Value::none(std::string why) {
  Value v(0);
  v.value.reset();
  v.reason = std::move(why);
  return v;
}

Value ate_se3_rmse(const Scored& s) { return ate(s, Alignment::se3); }
Value ate_yaw_rmse(const Scored& s) { return ate(s, Alignment::yaw_position); }
Value ate_sim3_rmse(const Scored& s) { return ate(s, Alignment::sim3); }
Value rmse(const Scored& s) { return ate(s, Alignment::none); }

Value scale_error(const Scored& s) {
  return of_aligned(s, Alignment::sim3, [](const Similarity& S) -> Value { return 100 * (1 / S.scale - 1); });
}

Value relative_1m_translation(const Scored& s) {
  return relative_1m(s, [](const RelativeError& error) { return error.translation; });
}
Value relative_1m_rotation(const Scored& s) {
  return relative_1m(s, [](const RelativeError& error) { return error.rotation / kDegree; });
}

Value end_position_error(const Scored& s) {
  return of_estimate(s, [&]() -> Value { return end_distance(s); });
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

Value nees_position(const Scored& s) {
  return mean_nees(s, [](const PoseNees& nees) { return nees.position; });
}
Value nees_orientation(const Scored& s) {
  return mean_nees(s, [](const PoseNees& nees) { return nees.orientation; });
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

Value foot_slip_landing(const Scored& s) { return of_feet(s, FootPhase::landing, kMoved); }
Value foot_slip_support(const Scored& s) { return of_feet(s, FootPhase::support, kMoved); }
Value foot_slip_lift_off(const Scored& s) { return of_feet(s, FootPhase::lift_off, kMoved); }
Value foot_turn_landing(const Scored& s) { return of_feet(s, FootPhase::landing, kTurned); }
Value foot_turn_support(const Scored& s) { return of_feet(s, FootPhase::support, kTurned); }
Value foot_turn_lift_off(const Scored& s) { return of_feet(s, FootPhase::lift_off, kTurned); }
Value foot_creep(const Scored& s) {
  return on_ground(s, [](const FootTotal& t) { return t.creep; });
}
Value foot_creep_turn(const Scored& s) {
  return on_ground(s, [](const FootTotal& t) { return t.creep_turn / kDegree; });
}
Value slip_drift_x(const Scored& s) { return on_ground(s, kDriftX); }
Value slip_drift_y(const Scored& s) { return on_ground(s, kDriftY); }
Value slip_drift_yaw(const Scored& s) { return on_ground(s, kDriftYaw); }
Value put_down_drift_x(const Scored& s) { return of_feet(s, FootPhase::put_down, kDriftX); }
Value put_down_drift_y(const Scored& s) { return of_feet(s, FootPhase::put_down, kDriftY); }
Value put_down_drift_yaw(const Scored& s) { return of_feet(s, FootPhase::put_down, kDriftYaw); }

Value loop_landmark_count(const Scored& s) {
  if (!s.no_loop.empty()) return Value::none(s.no_loop);
  return static_cast<double>(s.loop.size());
}

Value loop_closed(const Scored& s) {
  if (!s.no_loop.empty()) return Value::none(s.no_loop);
  return s.loop.size() >= 3 ? 1 : 0;
}

Value loop_time(const Scored& s) {
  return of_closure(s, [](Stamp t) -> Value { return static_cast<double>(t.count()) * 1e-9; });
}

Value loop_error_before(const Scored& s) {
  return of_closure(s, [&](Stamp t) { return error_until(s, t - Stamp(1)); });
}

Value loop_error_after(const Scored& s) {
  return of_closure(s, [&](Stamp t) { return error_until(s, t + std::chrono::seconds(1)); });
}

}  // namespace sim::score
