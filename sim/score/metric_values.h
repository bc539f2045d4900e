// How each metric is computed; what it means in words is in evaluate.cc's table.
#pragma once

#include <optional>
#include <string>

#include "sim/score/scored.h"

namespace sim::score {

/// A metric's value in its unit, or why there is none.
struct Value {
  Value(double v) : value(v) {}
  static Value none(std::string why);

  std::optional<double> value;
  std::string reason;
};

// The estimate against the truth.
Value ate_se3_rmse(const Scored& s);
Value ate_yaw_rmse(const Scored& s);
Value ate_sim3_rmse(const Scored& s);
Value scale_error(const Scored& s);
Value rmse(const Scored& s);
Value relative_1m_translation(const Scored& s);
Value relative_1m_rotation(const Scored& s);
Value end_position_error(const Scored& s);
Value drift_percent(const Scored& s);
Value end_yaw_error(const Scored& s);
Value estimated_height_range(const Scored& s);
Value nees_position(const Scored& s);
Value nees_orientation(const Scored& s);

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

}  // namespace sim::score
