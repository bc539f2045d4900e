#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

#include "sim/scenario/keys.h"

namespace sim::scenario {
namespace {

struct FormerNames {
  std::string_view note;
  std::string_view names;  ///< each between spaces
};
constexpr FormerNames kFormer[]{
    {"was renamed to slam.vision.match_bias_sigma_px", " slam.vision.sigma_lasting_px "},
    {"was renamed to slam.vision.match_bias_s", " slam.vision.lasting_s "},
    {"was renamed to slam.vision.viewpoint_sigma_px", " slam.vision.sigma_view_px "},
    {"was renamed to tracked_fraction", " tracked_share "},
    {"was renamed to fault_flag_fraction", " suspect_share "},
    {"is gone: it had no effect by default",
     " slam.plan_orientation.enabled slam.plan_orientation.sigma_rad slam.plan_position.enabled "
     "slam.plan_position.sigma_m slam.plan_velocity.standing_factor slam.plan_velocity.double_support_factor "
     "slam.plan_velocity.landing_factor slam.plan_velocity.landing_s slam.plan_velocity.slip_time_s "
     "slam.plan_velocity.sigma_per_turn_m slam.plan_velocity.sigma_slip_m_s "},
    {"is gone: it is a constant",
     " slam.plan_velocity.stride_time_s slam.plan_velocity.sway_ahead slam.plan_velocity.sway_up "
     "slam.plan_velocity.sway_time_s slam.leg_odometry.landing_factor slam.leg_odometry.landing_s "
     "slam.accelerometer.sigma_frame_m_s2 slam.tracking.vision_bound slam.tracking.height_bound "
     "slam.bounds.searched_px stabilizer.tracking.sole_margin_m stabilizer.ankle_admittance.leak_s "
     "stabilizer.ankle_admittance.limit_rad stabilizer.force_difference.leak_s "
     "stabilizer.force_difference.leak_in_swing_s stabilizer.force_difference.limit_m "
     "stabilizer.leg_compliance.lag_s stabilizer.body_attitude.leak_s stabilizer.body_attitude.limit_rad "},
    {"is gone: relocalization is always on; slam.tracking.give_up_s bounds it", " slam.tracking.relocalise "},
    {"is gone: compile the library as a program with -DGAITSLAM_ESTIMATOR_MAIN, and give estimator.program",
     " estimator.library "},
    {"is gone: the capture-point law is the only one",
     " stabilizer.tracking.law stabilizer.tracking.delayed_zmp.lag_s "
     "stabilizer.tracking.delayed_zmp.fast_pole_per_s stabilizer.tracking.delayed_zmp.slow_pole_per_s "},
    {"is gone: no limit, page or README used it",
     " ate_origin_rmse_m ate_scale_rmse_m contact_creep_deg contact_creep_m end_error_x_m "
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
};

}  // namespace

std::string former_name(std::string_view name) {
  for (const auto& [note, names] : kFormer)
    if (names.find(fmt::format(" {} ", name)) != names.npos) return std::string(note);
  return "";
}

std::string unknown_key(std::string_view name) {
  if (const std::string former = former_name(name); !former.empty()) return former;
  std::vector<std::string_view> names;
  for (const Key& key : scenario_keys()) names.push_back(key.name);
  return "unknown key" + did_you_mean(name, names);
}

}  // namespace sim::scenario
