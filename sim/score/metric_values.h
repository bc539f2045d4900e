// How each metric is computed; what it means in words is in metric_table.cc.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "sim/score/alignment.h"
#include "sim/score/relative.h"
#include "sim/score/scored.h"

namespace sim::score {

/// A metric's value in its unit, or why there is none.
struct Value {
  Value(double v) : value(v) {}
  static Value none(std::string why);

  std::optional<double> value;
  std::string reason;
};

/// value(), if anything can be said of the estimate.
template <typename F>
Value of_estimate(const Scored& s, F value) {
  if (!s.no_estimate.empty()) return Value::none(s.no_estimate);
  return value();
}

// The estimate against the truth.
Value ate(const Scored& s, Alignment alignment);
Value scale_error(const Scored& s);
Value poses_matched(const Scored& s);
Value rmse_along(const Scored& s, int axis);
Value rotation_rmse(const Scored& s);
Value yaw_rmse(const Scored& s);
Value relative_translation(const Scored& s, const Spans& over);
Value relative_rotation(const Scored& s, const Spans& over);
Value step_translation(const Scored& s);
Value step_rotation(const Scored& s);
Value end_position_error(const Scored& s);
Value end_error_along(const Scored& s, int axis);
Value drift_percent(const Scored& s);
Value end_yaw_error(const Scored& s);
Value estimated_height_range(const Scored& s);
Value walk_completion(const Scored& s);
Value track_completion(const Scored& s);

// The walk itself, against its plan.
Value true_height_range(const Scored& s);
Value true_path_length(const Scored& s);
Value plan_rmse(const Scored& s);
Value plan_drift_x(const Scored& s);
Value plan_drift_y(const Scored& s);
Value plan_drift_yaw(const Scored& s);

// Where its drift comes from, foot by foot.
Value foot_slip_landing(const Scored& s);
Value foot_slip_support(const Scored& s);
Value foot_slip_lift_off(const Scored& s);
Value foot_turn_landing(const Scored& s);
Value foot_turn_support(const Scored& s);
Value foot_turn_lift_off(const Scored& s);
Value foot_creep(const Scored& s);
Value foot_creep_turn(const Scored& s);
Value slip_drift_x(const Scored& s);
Value slip_drift_y(const Scored& s);
Value slip_drift_yaw(const Scored& s);
Value put_down_drift_x(const Scored& s);
Value put_down_drift_y(const Scored& s);
Value put_down_drift_yaw(const Scored& s);

// The closing of the loop.
Value loop_landmark_count(const Scored& s);
Value loop_closed(const Scored& s);
Value loop_time(const Scored& s);
Value loop_error_before(const Scored& s);
Value loop_error_after(const Scored& s);
Value loop_sigma_before(const Scored& s);
Value loop_sigma_after(const Scored& s);
Value loop_logdet_drop(const Scored& s);
Value loop_correction(const Scored& s);
Value loop_correction_turn(const Scored& s);

// Whether the filter is as sure as it should be, and its map.
Value nees_mean(const Scored& s, double PoseNees::*part);
Value nees_variance(const Scored& s, double PoseNees::*part);
Value nees_within(const Scored& s, double PoseNees::*part);
Value innovations(const Scored& s, std::size_t sensor,
                  const std::function<double(const InnovationSummary&)>& part);
Value landmark_rmse(const Scored& s);
Value landmark_median(const Scored& s);
Value landmark_nees(const Scored& s);
Value landmarks_scored(const Scored& s);

}  // namespace sim::score
