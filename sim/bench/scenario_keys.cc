#include "sim/bench/scenario_keys.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "sim/bench/estimators.h"
#include "sim/bench/scenario_commands.h"
#include "sim/bench/scenario_disturbances.h"
#include "sim/bench/scenario_faults.h"

namespace sim::bench {
namespace {

using std::string_view_literals::operator""sv;

template <class Section>
auto& section(Section& s) {
  return s;
}
template <class Section>
auto& section(std::optional<Section>& s) {
  return *s;
}
template <class Section>
auto& section(const std::optional<Section>& s) {
  return *s;
}

// The key's name is the member's name: written once, checked by the compiler.
#define GAITSLAM_KEY(part, member) \
#part "." #member, [](auto&& scenario) -> auto& { return section(scenario.part).member; }

constexpr Domain kAny{}, kSigma{1e-9, 1e6}, kSpread{0, 1e3}, kPixels{16, 4096}, kFraction{0, 1},
    kGain{0, 1e6}, kTime{1e-3, 1e6};
constexpr std::array kSwing{"quintic"sv, "cubic"sv}, kLens{"wide"sv, "pinhole"sv}, kAxes{"robot"sv, "plan"sv};
constexpr std::array kLaw{"capture_point"sv, "delayed_zmp"sv};
constexpr std::array kArms{"still"sv, "swing"sv, "momentum"sv};
constexpr std::array kReadings{"all"sv, "last"sv}, kFirstSight{"inverse_depth"sv, "particles"sv};

template <class Access>
Key<Scenario> key(const std::string& name, Access access, const Domain& domain, const std::string& doc) {
  return make_key<Scenario>(name, access, domain, doc, default_scenario());
}

using Keys = std::vector<Key<Scenario>>;

void add_run(Keys& keys) {
  keys.push_back(key(
      "name", [](auto&& s) -> auto& { return s.name; }, kAny,
      "of the results folder; default: the file's name"));
  keys.push_back(key(
      "seed", [](auto&& s) -> auto& { return s.seed; }, kAny, "of every random stream of the run"));
}

Key<Scenario> commands_key() {
  return {"walk.commands", "a list of commands", "what the robot does, in order",
          [](const Yaml& node, Scenario& s) { read_commands(node, "walk.commands", s.walk.commands); },
          [](const Scenario& s) { return print_commands(s.walk.commands); }};
}

void add_walk(Keys& keys) {
  keys.push_back(key(GAITSLAM_KEY(walk, single_support_s), {0.1, 5}, "time on one foot in a step"));
  keys.push_back(key(GAITSLAM_KEY(walk, double_support_s), {0.005, 5}, "time on both feet between steps"));
  keys.push_back(key(GAITSLAM_KEY(walk, step_height_m), {0.005, 0.2}, "how high the swing foot is lifted"));
  keys.push_back(
      key(GAITSLAM_KEY(walk, step_length_m), {0.01, 0.4}, "what the body advances in a step, at most"));
  keys.push_back(key(GAITSLAM_KEY(walk, preview_s), {0.1, 10}, "how far ahead the controller sees the ZMP"));
  keys.push_back(key(GAITSLAM_KEY(walk, com_height_m), {0.3, 1.5}, "height of the cart-table model"));
  keys.push_back(key(GAITSLAM_KEY(walk, swing), {0, 0, kSwing}, "polynomial of the swing foot"));
  keys.push_back(key(GAITSLAM_KEY(walk, arm_motion), {0, 0, kArms},
                     "arms keep half-sitting, swing against the legs, or take up the body's yaw momentum"));
  keys.push_back(key(GAITSLAM_KEY(walk, second_preview), kAny,
                     "the ZMP of the whole body follows the reference, not the cart-table's"));
  keys.push_back(commands_key());
}

void add_stabilizer(Keys& keys) {
  keys.push_back(key(GAITSLAM_KEY(stabilizer, enabled), kAny, "correct the plan by what the robot feels"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, attitude.enabled), kAny,
                     "feel the tilt by gyro and accelerometer; else the waist counts as upright"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, attitude.accelerometer_gain_per_s), kGain,
                     "how fast the gyro's drift is pulled back to the felt vertical"));
  keys.push_back(
      key(GAITSLAM_KEY(stabilizer, attitude.bias_gain_per_s2), kGain, "how fast a gyro bias is learnt"));
  keys.push_back(
      key(GAITSLAM_KEY(stabilizer, tracking.enabled), kAny, "answer errors of the centre of mass"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, tracking.law), {0, 0, kLaw},
                     "feedback of the capture point, or of centre of mass, its velocity and a lagging ZMP"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, tracking.gain_per_s), kGain,
                     "how fast the capture point's error shall decay"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, tracking.velocity_cutoff_hz), {0.01, 100},
                     "low pass on the velocity error of the centre of mass"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, tracking.sole_margin_m), {0, 0.1},
                     "the pressure asked for stays this far inside a sole"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, tracking.delayed_zmp.lag_s), kTime,
                     "with which the ZMP follows the one asked for, as that law has it"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, tracking.delayed_zmp.fast_pole_per_s), kGain,
                     "rate at which errors decay under that law"));
  keys.push_back(
      key(GAITSLAM_KEY(stabilizer, tracking.delayed_zmp.slow_pole_per_s), kGain, "likewise, the slower one"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, distribution.enabled), kAny,
                     "feet share the load as the ZMP asked for says; else half each"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, ankle_admittance.enabled), kAny,
                     "ankles give way to the torque they feel"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, ankle_admittance.gain_rad_s_per_nm), kGain,
                     "speed of giving way for a torque beyond what is asked for"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, ankle_admittance.leak_s), kTime,
                     "time in which the correction dies away"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, ankle_admittance.limit_rad), {0, 1}, "largest correction"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, force_difference.enabled), kAny,
                     "the foot that carries too little reaches down, the other up"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, force_difference.gain_m_s_per_n), kGain,
                     "speed of reaching for a force that is missing"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, force_difference.leak_s), kTime,
                     "time in which the correction dies away while both feet stand"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, force_difference.leak_in_swing_s), kTime,
                     "likewise while one foot swings"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, force_difference.limit_m), {0, 0.2}, "largest correction"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, leg_compliance.enabled), kAny,
                     "a leg is made longer by what its planned load compresses it"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, leg_compliance.stiffness_n_m), {1e3, 1e9},
                     "of a leg from waist to ground, vertically"));
  keys.push_back(
      key(GAITSLAM_KEY(stabilizer, leg_compliance.lag_s), {0, 1}, "time in which a leg gives way"));
  keys.push_back(
      key(GAITSLAM_KEY(stabilizer, body_attitude.enabled), kAny, "the waist is turned against its tilt"));
  keys.push_back(
      key(GAITSLAM_KEY(stabilizer, body_attitude.gain_per_s), kGain, "how fast the tilt is turned back"));
  keys.push_back(
      key(GAITSLAM_KEY(stabilizer, body_attitude.leak_s), kTime, "time in which the correction dies away"));
  keys.push_back(key(GAITSLAM_KEY(stabilizer, body_attitude.limit_rad), {0, 1}, "largest correction"));
}

template <class Access>
Key<Scenario> disturbances_key(const std::string& name, Access access, const std::string& doc) {
  return {name, "a list", doc,
          [=](const Yaml& node, Scenario& s) { read_disturbances(node, name, access(s)); },
          [=](const Scenario& s) { return print_disturbances(access(s)); }};
}

void add_world(Keys& keys) {
  keys.push_back(key(GAITSLAM_KEY(world, robot), kAny, "the robot's model, models/<robot>.xml"));
  keys.push_back(key(GAITSLAM_KEY(world, room), kAny, "the room's model, models/<room>.xml"));
  keys.push_back(key(GAITSLAM_KEY(world, seed), kAny, "of what is painted on the room's surfaces"));
  keys.push_back(key(GAITSLAM_KEY(world, floor_friction), {0.01, 5}, "sliding friction of sole on floor"));
  keys.push_back(disturbances_key(GAITSLAM_KEY(world, floor_patches),
                                  "rectangles of the floor with a friction of their own"));
  keys.push_back(disturbances_key(GAITSLAM_KEY(world, pushes), "pushes against the waist"));
  keys.push_back(
      key(GAITSLAM_KEY(world, lights_off.from_s), kGain, "when the room's lamps are switched off"));
  keys.push_back(key(GAITSLAM_KEY(world, lights_off.duration_s), kGain, "for how long; 0: never"));
  keys.push_back(key(GAITSLAM_KEY(world, lights_off.left_fraction), kFraction,
                     "light that surfaces then still get; windows and screens shine on"));
  keys.push_back(key(GAITSLAM_KEY(world, variation.friction), kSpread,
                     "standard deviation of floor_friction over seeds"));
  keys.push_back(key(GAITSLAM_KEY(world, variation.joint_offset_rad), {0, 0.1},
                     "standard deviation of each joint's zero over seeds"));
  keys.push_back(key(GAITSLAM_KEY(world, variation.mass_fraction), {0, 0.2},
                     "standard deviation of each link's mass over seeds, relative"));
  keys.push_back(key(GAITSLAM_KEY(world, variation.com_m), {0, 0.1},
                     "standard deviation of each link's centre of mass over seeds, along each axis"));
  keys.push_back(key(GAITSLAM_KEY(world, variation.posture_rad), {0, 0.1},
                     "standard deviation of each joint's angle at the start over seeds"));
  keys.push_back(key(GAITSLAM_KEY(world, variation.servo_fraction), {0, 0.2},
                     "standard deviation of each servo's gain over seeds, relative"));
  keys.push_back(key(GAITSLAM_KEY(world, variation.floor_height_m), {0, 0.01},
                     "standard deviation of the floor's height, in waves of 1 to 4 m"));
}

void add_camera(Keys& keys) {
  keys.push_back(key(GAITSLAM_KEY(camera, width_px), kPixels, "width of the image"));
  keys.push_back(key(GAITSLAM_KEY(camera, height_px), kPixels, "height of the image"));
  keys.push_back(key(GAITSLAM_KEY(camera, rate_hz), {0.1, 1000}, "frames per second of simulated time"));
  keys.push_back(key(GAITSLAM_KEY(camera, lens), {0, 0, kLens},
                     "wide: one-parameter radial lens, 91.6 deg across; pinhole: ideal, 90 deg"));
  keys.push_back(key(GAITSLAM_KEY(camera, samples), {0, 16}, "multisampling of the renderer"));
  keys.push_back(
      key(GAITSLAM_KEY(camera, exposure_s), {0, 0.1}, "how long each row gathers light: motion blur"));
  keys.push_back(key(GAITSLAM_KEY(camera, readout_s), {0, 0.1},
                     "from the first row's exposure to the last row's: rolling shutter"));
  keys.push_back(key(GAITSLAM_KEY(camera, subframes), {2, 64},
                     "pictures drawn for each frame when exposure_s or readout_s is not 0"));
}

Key<Scenario> faults_key() {
  return {"errors.faults", "a list of faults", "what goes wrong with the sensors for a while",
          [](const Yaml& node, Scenario& s) { read_faults(node, "errors.faults", s.errors.faults); },
          [](const Scenario& s) { return print_faults(s.errors.faults); }};
}

void add_errors(Keys& keys) {
  keys.push_back(
      key(GAITSLAM_KEY(errors, gyro.sigma_rad_s), kSpread, "white noise of a 200 Hz gyro reading"));
  keys.push_back(key(GAITSLAM_KEY(errors, gyro.bias_sigma_rad_s), kSpread,
                     "standard deviation of the gyro's constant bias over seeds"));
  keys.push_back(key(GAITSLAM_KEY(errors, gyro.bias_walk_sigma_rad_s2), kSpread,
                     "growth of the bias's standard deviation in 1 s"));
  keys.push_back(key(GAITSLAM_KEY(errors, gyro.range_rad_s), kSpread,
                     "readings beyond are cut to it; 0: there is no end"));
  keys.push_back(key(GAITSLAM_KEY(errors, gyro.resolution_rad_s), kSpread,
                     "readings are whole multiples of it; 0: not rounded"));
  keys.push_back(key(GAITSLAM_KEY(errors, accelerometer.sigma_m_s2), kSpread,
                     "white noise of a 200 Hz accelerometer reading"));
  keys.push_back(key(GAITSLAM_KEY(errors, accelerometer.bias_sigma_m_s2), kSpread,
                     "standard deviation of the accelerometer's constant bias over seeds"));
  keys.push_back(key(GAITSLAM_KEY(errors, accelerometer.bias_walk_sigma_m_s3), kSpread,
                     "growth of the bias's standard deviation in 1 s"));
  keys.push_back(key(GAITSLAM_KEY(errors, accelerometer.range_m_s2), kSpread,
                     "readings beyond are cut to it; 0: there is no end"));
  keys.push_back(key(GAITSLAM_KEY(errors, accelerometer.resolution_m_s2), kSpread,
                     "readings are whole multiples of it; 0: not rounded"));
  keys.push_back(key(GAITSLAM_KEY(errors, image.read_sigma_grey), {0, 100},
                     "noise of a black pixel, of 255 grey levels"));
  keys.push_back(key(GAITSLAM_KEY(errors, image.shot_sigma_grey), {0, 50},
                     "noise of a white pixel from counting light alone"));
  keys.push_back(key(GAITSLAM_KEY(errors, image.gain), {0, 16}, "of the camera, after its noise"));
  keys.push_back(key(GAITSLAM_KEY(errors, image.vignetting_fraction), kFraction,
                     "light that the corners lack; grows with the squared distance from the centre"));
  keys.push_back(key(GAITSLAM_KEY(errors, image.exposure_sigma_fraction), {0, 10},
                     "standard deviation of the exposure about its mean"));
  keys.push_back(key(GAITSLAM_KEY(errors, image.exposure_time_s), kTime, "in which the exposure wanders"));
  keys.push_back(key(GAITSLAM_KEY(errors, image.loss_fraction), kFraction, "frames whose image is lost"));
  keys.push_back(key(GAITSLAM_KEY(errors, image.latency_s), {0, 10},
                     "a frame brings the newest picture that is at least this old"));
  keys.push_back(
      key(GAITSLAM_KEY(errors, plan.loss_fraction), kFraction, "frames whose planned motion is lost"));
  keys.push_back(key(GAITSLAM_KEY(errors, plan.velocity_sigma_m_s), kSpread,
                     "white error of the planned velocity, along x and y of the plan's world"));
  keys.push_back(key(GAITSLAM_KEY(errors, motion.time_offset_s), {-1, 1},
                     "how much later the motion computer stamps readings and plan than the vision computer"));
  keys.push_back(faults_key());
}

Key<Scenario> estimator_key() {
  const Domain names{0, 0, estimator_names()};
  return {"estimator", expected_choice(names),
          "what is run on the observations, beside or instead of the filter",
          [names](const Yaml& node, Scenario& s) {
            s.estimator = names.choices[read_choice(node, "estimator", names)];
          },
          [](const Scenario& s) { return s.estimator; }};
}

void add_slam(Keys& keys) {
  keys.push_back(estimator_key());
  keys.push_back(
      key(GAITSLAM_KEY(slam, start.sigma_position_m), kSigma, "standard deviation of the first position"));
  keys.push_back(key(GAITSLAM_KEY(slam, start.sigma_orientation_rad), kSigma,
                     "standard deviation of the first orientation"));
  keys.push_back(
      key(GAITSLAM_KEY(slam, start.sigma_velocity_m_s), kSigma, "standard deviation of the first velocity"));
  keys.push_back(key(GAITSLAM_KEY(slam, start.sigma_rate_rad_s), kSigma,
                     "standard deviation of the first angular rate"));
  keys.push_back(
      key(GAITSLAM_KEY(slam, motion.sigma_acceleration_m_s2), kSigma, "unknown acceleration of the camera"));
  keys.push_back(key(GAITSLAM_KEY(slam, motion.sigma_angular_acceleration_rad_s2), kSigma,
                     "unknown angular acceleration of the camera"));
  keys.push_back(key(GAITSLAM_KEY(slam, gyro.enabled), kAny, "use the gyro"));
  keys.push_back(key(GAITSLAM_KEY(slam, gyro.readings), {0, 0, kReadings},
                     "of a frame interval that are used: all, or the last one alone"));
  keys.push_back(
      key(GAITSLAM_KEY(slam, gyro.sigma_rad_s), kSigma, "noise the filter expects of a 200 Hz gyro sample"));
  keys.push_back(key(GAITSLAM_KEY(slam, gyro.sigma_bias_rad_s), kSpread,
                     "uncertainty of the gyro's bias at the start; 0: there is none"));
  keys.push_back(key(GAITSLAM_KEY(slam, gyro.sigma_bias_walk_rad_s2), kSpread,
                     "growth of the bias's standard deviation in 1 s"));
  keys.push_back(
      key(GAITSLAM_KEY(slam, accelerometer.enabled), kAny, "use the accelerometer in the motion model"));
  keys.push_back(key(GAITSLAM_KEY(slam, accelerometer.sigma_m_s2), kSigma,
                     "noise the filter expects of a 200 Hz accelerometer sample"));
  keys.push_back(key(GAITSLAM_KEY(slam, accelerometer.sigma_bias_m_s2), kSpread,
                     "uncertainty of its bias at the start; 0: there is none"));
  keys.push_back(key(GAITSLAM_KEY(slam, accelerometer.sigma_bias_walk_m_s3), kSpread,
                     "growth of the bias's standard deviation in 1 s"));
  keys.push_back(key(GAITSLAM_KEY(slam, accelerometer.sigma_frame_m_s2), kSpread,
                     "what each frame adds: the head moves not quite as the chest"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_velocity.enabled), kAny, "use the planned velocity"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_velocity.axes), {0, 0, kAxes},
                     "axes in which the planned velocity is trusted"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_velocity.pivots_on_foot), kAny,
                     "turning unknown to the plan is about the support foot"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_velocity.sigma_m_s), kSigma,
                     "error the filter expects of the planned velocity"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_velocity.standing_factor), {1e-3, 1e3},
                     "of sigma_m_s while the plan stands still"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_velocity.double_support_factor), {1e-3, 1e3},
                     "likewise while it has both feet on the ground"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_velocity.landing_factor), {1e-3, 1e3},
                     "likewise just after it has set a foot down"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_velocity.landing_s), {0, 10}, "how long that is"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_velocity.sigma_per_turn_m), kSpread,
                     "added to sigma_m_s for each rad/s that the plan turns"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_velocity.sigma_slip_m_s), kSpread,
                     "slowly changing error of the planned velocity; 0: there is none"));
  keys.push_back(
      key(GAITSLAM_KEY(slam, plan_velocity.slip_time_s), {0.001, 1e6}, "how long that error lasts"));
  keys.push_back(
      key(GAITSLAM_KEY(slam, plan_velocity.sigma_stride), kSpread,
          "part by which planned strides are wrong for long, in length and aside; 0: they are not"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_velocity.stride_time_s), kTime, "how long that is"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_velocity.sigma_sway_m_s), kSpread,
                     "velocity of swaying aside that the plan does not know of"));
  keys.push_back(
      key(GAITSLAM_KEY(slam, plan_velocity.sway_ahead), {0, 10}, "part of that: of swaying ahead"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_velocity.sway_up), {0, 10}, "likewise up"));
  keys.push_back(
      key(GAITSLAM_KEY(slam, plan_velocity.sway_period_s), kTime, "of that swaying: that of two steps"));
  keys.push_back(
      key(GAITSLAM_KEY(slam, plan_velocity.sway_time_s), kTime, "how long it goes on undisturbed"));
  keys.push_back(key(GAITSLAM_KEY(slam, height.enabled), kAny, "use the planned height"));
  keys.push_back(
      key(GAITSLAM_KEY(slam, height.sigma_m), kSigma, "error the filter expects of the planned height"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_orientation.enabled), kAny, "use the planned orientation"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_orientation.sigma_rad), kSigma, "error expected of it"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_position.enabled), kAny, "use the planned position"));
  keys.push_back(key(GAITSLAM_KEY(slam, plan_position.sigma_m), kSigma, "error expected of it"));
  keys.push_back(key(GAITSLAM_KEY(slam, vision.enabled), kAny, "use the camera"));
  keys.push_back(key(GAITSLAM_KEY(slam, vision.sigma_px), {0.01, 100},
                     "image noise at the centre; twice that at the corner"));
  keys.push_back(key(GAITSLAM_KEY(slam, vision.sigma_first_px), {0.001, 100},
                     "likewise of the pixel where a landmark was first seen"));
  keys.push_back(
      key(GAITSLAM_KEY(slam, vision.sigma_view_px), {0, 100},
          "change of what a patch takes for its centre, once the camera has moved by its distance"));
  keys.push_back(key(GAITSLAM_KEY(slam, vision.gate_sigma_px), {0.01, 100},
                     "scatter of a single right match, by which wrong ones are told"));
  keys.push_back(key(GAITSLAM_KEY(slam, vision.visible_landmarks), {1, 1000}, "landmarks to keep in view"));
  keys.push_back(key(GAITSLAM_KEY(slam, vision.measured_landmarks), {1, 1000},
                     "landmarks to measure in a frame, the least certain of those in view"));
  keys.push_back(key(GAITSLAM_KEY(slam, vision.minimum_correlation), {-1, 1},
                     "normalised correlation a match must reach"));
  keys.push_back(key(GAITSLAM_KEY(slam, vision.corner_threshold), {0, 1e9},
                     "smaller eigenvalue of the gradient moments that makes a corner"));
  keys.push_back(key(GAITSLAM_KEY(slam, vision.warped_patches), kAny,
                     "templates as the predicted view should show them; else as first seen"));
  keys.push_back(key(GAITSLAM_KEY(slam, vision.estimate_normals), kAny,
                     "learn which way landmarks' surfaces are turned; else they face their first sight"));
  keys.push_back(key(GAITSLAM_KEY(slam, vision.sub_pixel), kAny, "matches are refined below the pixel"));
  keys.push_back(key(GAITSLAM_KEY(slam, vision.consensus), kAny,
                     "only matches that agree among themselves are used (1-point RANSAC)"));
  keys.push_back(key(GAITSLAM_KEY(slam, tracking.lost_after_s), kTime,
                     "tracking is lost after that long with almost no landmark found"));
  keys.push_back(key(GAITSLAM_KEY(slam, tracking.vision_bound), {1e-3, 1e9},
                     "or when the mean NIS per row of 15 frames' matches is beyond that"));
  keys.push_back(
      key(GAITSLAM_KEY(slam, tracking.height_bound), {1e-3, 1e9}, "or that of the planned height"));
  keys.push_back(key(GAITSLAM_KEY(slam, tracking.relocalise), kAny,
                     "when lost, look for the map in the whole image; else the filter has diverged"));
  keys.push_back(key(GAITSLAM_KEY(slam, tracking.give_up_s), kTime,
                     "the filter has diverged after that long of images without the map"));
  keys.push_back(key(GAITSLAM_KEY(slam, depth.first_sight), {0, 0, kFirstSight},
                     "a landmark begins by inverse depth, or as a line with depth particles"));
  keys.push_back(
      key(GAITSLAM_KEY(slam, depth.inverse_1_m), {1e-6, 100}, "inverse depth that a landmark begins with"));
  keys.push_back(key(GAITSLAM_KEY(slam, depth.sigma_inverse_1_m), {1e-6, 100}, "its standard deviation"));
  keys.push_back(key(GAITSLAM_KEY(slam, depth.linearity), {0, 10},
                     "a landmark becomes a point below this linearity index; 0: never"));
  keys.push_back(key(GAITSLAM_KEY(slam, depth.particles.count), {2, 10000}, "depth particles of a line"));
  keys.push_back(key(GAITSLAM_KEY(slam, depth.particles.nearest_m), {0.01, 1000}, "depth of the first"));
  keys.push_back(key(GAITSLAM_KEY(slam, depth.particles.furthest_m), {0.02, 1000}, "depth of the last"));
  keys.push_back(key(GAITSLAM_KEY(slam, depth.particles.converged), {0.001, 1},
                     "a line becomes a point when the depth's deviation is this part of its mean"));
  keys.push_back(key(GAITSLAM_KEY(slam, depth.particles.fewest), {1, 10000},
                     "particles below which a line is given up"));
  keys.push_back(key(GAITSLAM_KEY(slam, depth.particles.attempts), {1, 100000},
                     "frames after which a line is given up"));
  keys.push_back(key(GAITSLAM_KEY(slam, depth.particles.at_once), {1, 1000}, "lines in the map"));
  keys.push_back(key(GAITSLAM_KEY(slam, depth.particles.minimum_speed_m_s), kSpread,
                     "slower than this no line is begun"));
  keys.push_back(key(GAITSLAM_KEY(slam, known_landmarks.at_m), {-1000, 1000},
                     "corners known beforehand, looked for in the first image"));
  keys.push_back(key(GAITSLAM_KEY(slam, known_landmarks.sigma_m), {1e-6, 10}, "how well they are known"));
  keys.push_back(key(GAITSLAM_KEY(slam, consistency.observability_constrained), kAny,
                     "no measurement may seem to tell the world's heading"));
}

void add_limits(Keys& keys) {
  keys.push_back(key(GAITSLAM_KEY(limits, ending), {0, 0, kEndings}, "endings with which a run can pass"));
}

}  // namespace

const Keys& scenario_keys() {
  static const Keys all = [] {
    Keys keys;
    add_run(keys);
    add_walk(keys);
    add_stabilizer(keys);
    add_world(keys);
    add_camera(keys);
    add_errors(keys);
    add_slam(keys);
    add_limits(keys);
    return keys;
  }();
  return all;
}

const Key<Scenario>* find_key(std::string_view name) {
  const auto& all = scenario_keys();
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& key) { return key.name == name; });
  return found == all.end() ? nullptr : &*found;
}

const Scenario& default_scenario() {
  static const Scenario scenario = [] {
    Scenario s;
    s.camera.emplace();
    s.slam.emplace();
    return s;
  }();
  return scenario;
}

bool has_section(const Scenario& scenario, std::string_view key) {
  if (key == "camera" || key.starts_with("camera.")) return scenario.camera.has_value();
  if (key == "slam" || key.starts_with("slam.")) return scenario.slam.has_value();
  return true;
}

std::string_view unit_of(std::string_view key) {
  using Ending = std::pair<std::string_view, std::string_view>;
  static constexpr Ending kUnits[]{{"_per_s2", "1/s²"},
                                   {"_per_s", "1/s"},
                                   {"_n_m", "N/m"},
                                   {"_m_s_per_n", "m/(N·s)"},
                                   {"_rad_s_per_nm", "rad/(N·m·s)"},
                                   {"_1_m", "1/m"},
                                   {"_grey", "grey"},
                                   {"_rad_s2", "rad/s²"},
                                   {"_rad_s", "rad/s"},
                                   {"_m_s2", "m/s²"},
                                   {"_m_s3", "m/s³"},
                                   {"_m_s", "m/s"},
                                   {"_px2", "px⁻²"},
                                   {"_px", "px"},
                                   {"_rad", "rad"},
                                   {"_deg", "deg"},
                                   {"_hz", "Hz"},
                                   {"_ms", "ms"},
                                   {"_ns", "N·s"},
                                   {"_s", "s"},
                                   {"_m", "m"},
                                   {"_kg", "kg"},
                                   {"_n", "N"}};
  for (const auto& [ending, unit] : kUnits) {
    if (key.ends_with(ending)) return unit;
  }
  return "";
}

}  // namespace sim::bench
