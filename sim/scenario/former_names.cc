#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/scenario/keys.h"

namespace sim::scenario {
namespace {

/// Former and present names of keys and metrics.
constexpr std::pair<std::string_view, std::string_view> kRenamed[]{
    {"slam.vision.sigma_lasting_px", "slam.vision.match_bias_sigma_px"},
    {"slam.vision.lasting_s", "slam.vision.match_bias_s"},
    {"slam.vision.sigma_view_px", "slam.vision.viewpoint_sigma_px"},
    {"tracked_share", "tracked_fraction"},
    {"suspect_share", "fault_flag_fraction"},
};

/// The reason, and the names that are gone for it, with a space after each.
constexpr std::pair<std::string_view, std::string_view> kGone[]{
    {"never used: the planned orientation drifts as the feet slip",
     "slam.plan_orientation.enabled slam.plan_orientation.sigma_rad "},
    {"never used: the planned position drifts as the feet slip",
     "slam.plan_position.enabled slam.plan_position.sigma_m "},
    {"had no effect by default (1)",
     "slam.plan_velocity.standing_factor slam.plan_velocity.double_support_factor "
     "slam.plan_velocity.landing_factor "},
    {"had no effect by default", "slam.plan_velocity.landing_s slam.plan_velocity.slip_time_s "},
    {"had no effect by default (0)",
     "slam.plan_velocity.sigma_per_turn_m slam.plan_velocity.sigma_slip_m_s "},
    {"is a constant of the motion model, 30 s", "slam.plan_velocity.stride_time_s "},
    {"is a constant of the motion model, 0.6", "slam.plan_velocity.sway_ahead "},
    {"is a constant of the motion model, 0.15", "slam.plan_velocity.sway_up "},
    {"is a constant of the motion model, 1 s", "slam.plan_velocity.sway_time_s "},
    {"is a constant of the plan's noise, 6", "slam.leg_odometry.landing_factor "},
    {"is a constant of the plan's noise, 0.2 s", "slam.leg_odometry.landing_s "},
    {"is a constant of the accelerometer's noise, 0.1 m/s^2", "slam.accelerometer.sigma_frame_m_s2 "},
    {"is a constant of the tracking monitor, 3", "slam.tracking.vision_bound "},
    {"is a constant of the tracking monitor, 10", "slam.tracking.height_bound "},
    {"relocalization is always on; slam.tracking.give_up_s bounds it", "slam.tracking.relocalise "},
    {"is a constant of the search, 400000 px", "slam.bounds.searched_px "},
    {"metric without a limit, page or README",
     "ate_origin_rmse_m ate_scale_rmse_m contact_creep_deg contact_creep_m end_error_x_m "
     "end_error_y_m end_error_z_m landmark_median_m landmarks_scored loop_correction_deg "
     "loop_correction_m loop_logdet_drop loop_sigma_after_m loop_sigma_before_m "
     "navigation_first_lap_rmse_m navigation_last_lap_rmse_m nis_gyro_band_high "
     "nis_gyro_band_low nis_gyro_whiteness nis_height_band_high nis_height_band_low "
     "nis_height_whiteness nis_plan_velocity_band_high nis_plan_velocity_band_low "
     "nis_plan_velocity_whiteness nis_vision_band_high nis_vision_band_low nis_vision_whiteness "
     "put_down_drift_x_m put_down_drift_y_m put_down_drift_yaw_deg rmse_x_m rmse_y_m rmse_z_m "
     "rpe_1s_deg rpe_1s_m rpe_25cm_deg rpe_25cm_m rpe_2m_deg rpe_2m_m rpe_4m_deg rpe_4m_m "
     "rpe_50cm_deg rpe_50cm_m rpe_step_deg rpe_step_m slip_drift_x_m slip_drift_y_m "
     "slip_drift_yaw_deg slip_landing_deg slip_landing_m slip_lift_off_deg slip_lift_off_m "
     "slip_support_deg slip_support_m walk_completion yaw_rmse_deg "},
    {"compile the library as a program with -DGAITSLAM_ESTIMATOR_MAIN, and give estimator.program",
     "estimator.library "},
    {"the capture-point law is the only one",
     "stabilizer.tracking.law stabilizer.tracking.delayed_zmp.lag_s "
     "stabilizer.tracking.delayed_zmp.fast_pole_per_s "
     "stabilizer.tracking.delayed_zmp.slow_pole_per_s "},
    {"is a constant of the stabilizer, 0.01 m", "stabilizer.tracking.sole_margin_m "},
    {"is a constant of the stabilizer, 1.5 s",
     "stabilizer.ankle_admittance.leak_s stabilizer.force_difference.leak_s "},
    {"is a constant of the stabilizer, 0.17 rad", "stabilizer.ankle_admittance.limit_rad "},
    {"is a constant of the stabilizer, 0.08 s", "stabilizer.force_difference.leak_in_swing_s "},
    {"is a constant of the stabilizer, 0.025 m", "stabilizer.force_difference.limit_m "},
    {"is a constant of the stabilizer, 0.03 s", "stabilizer.leg_compliance.lag_s "},
    {"is a constant of the stabilizer, 10 s", "stabilizer.body_attitude.leak_s "},
    {"is a constant of the stabilizer, 0.1 rad", "stabilizer.body_attitude.limit_rad "},
};

}  // namespace

std::vector<FormerName> former_names() {
  std::vector<FormerName> all;
  for (const auto& [name, now] : kRenamed) all.push_back({name, now, ""});
  for (auto [reason, names] : kGone)
    for (std::size_t end; (end = names.find(' ')) != names.npos; names.remove_prefix(end + 1))
      all.push_back({names.substr(0, end), "", reason});
  return all;
}

std::string former_name(std::string_view name) {
  for (const FormerName& former : former_names())
    if (former.name == name)
      return former.now.empty() ? fmt::format("is gone: {}", former.reason)
                                : fmt::format("was renamed to {}", former.now);
  return "";
}

std::string unknown_key(std::string_view name) {
  if (const std::string former = former_name(name); !former.empty()) return former;
  std::vector<std::string_view> names;
  for (const Key& key : scenario_keys()) names.push_back(key.name);
  return "unknown key" + did_you_mean(name, names);
}

}  // namespace sim::scenario
