// What can be set in the filter, with its defaults; the scenario's keys slam.* are these, name for name.
#pragma once

#include <Eigen/Geometry>
#include <variant>
#include <vector>

namespace slam {

/// One-parameter radial lens of Swaminathan & Nayar as used by MonoSLAM:
/// u_d = u_0 + u_c / sqrt(1 + 2 K1 |u_c|²), u_c = (fu x/z, fv y/z). k1_px2 = 0 is the ideal pinhole.
struct OneParameterRadial {
  double k1_px2 = 0;
};

/// Brown's lens with two radial and two tangential parameters (OpenCV's first four; EuRoC's
/// "radial-tangential").
struct RadialTangential {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
};

/// Kannala & Brandt 2006: the image's radius is f (θ + k1 θ³ + k2 θ⁵ + k3 θ⁷ + k4 θ⁹), θ from the axis
/// (OpenCV's fisheye; Kalibr's "equidistant").
struct Equidistant {
  double k1 = 0, k2 = 0, k3 = 0, k4 = 0;
};

using Lens = std::variant<OneParameterRadial, RadialTangential, Equidistant>;

/// z forward, u right, v down; the centre of the first pixel is (0, 0).
struct CameraIntrinsics {
  int width_px = 320, height_px = 240;
  double fu_px = 197.0, fv_px = 195.0, u0_px = 157.0, v0_px = 127.0;
  Lens lens = OneParameterRadial{7.37e-6};
};

/// How the sensors sit on the robot: known to the filter beforehand, as on the real one.
struct Calibration {
  CameraIntrinsics camera;
  Eigen::Isometry3d X_CG =
      Eigen::Isometry3d::Identity();  ///< chest IMU in the camera's frame (planned posture)
};

/// Where the velocity that the plan gives is trusted: along the robot's own axes, or along the plan's world
/// axes.
enum class VelocityAxes { robot, plan };

/// Which gyro readings of a frame interval are used: all of them, or the last alone, as the paper's.
enum class GyroReadings { all, last };

/// How a landmark is in the state from its first sight on: by inverse depth, or as a semi-infinite line with
/// depth particles that becomes a point later, as the paper's.
enum class FirstSight { inverse_depth, particles };

struct Options {
  struct Start {  ///< uncertainty of the first pose: covers the robot's settling on its feet
    double sigma_position_m = 0.001, sigma_orientation_rad = 0.002, sigma_velocity_m_s = 0.05,
           sigma_rate_rad_s = 0.05;
  } start;
  struct Motion {  ///< constant-velocity model: standard deviation of the unknown accelerations
    double sigma_acceleration_m_s2 = 4.0, sigma_angular_acceleration_rad_s2 = 6.0;
  } motion;
  struct Gyro {
    bool enabled = true;
    GyroReadings readings = GyroReadings::all;
    double sigma_rad_s = 0.01;          ///< per 200 Hz sample
    double sigma_bias_rad_s = 0;        ///< of the bias at the start; 0 = there is none
    double sigma_bias_walk_rad_s2 = 0;  ///< growth of its standard deviation in 1 s
  } gyro;
  struct Accelerometer {
    bool enabled = true;
    double sigma_m_s2 = 0.05;  ///< per 200 Hz sample
    double sigma_bias_m_s2 =
        0.015;  ///< of the bias at the start; the mounting's error of 1.5 mrad looks alike
    double sigma_bias_walk_m_s3 = 0.01;  ///< growth of its standard deviation in 1 s
    double sigma_frame_m_s2 = 0.1;  ///< what each frame adds: the head does not move quite as the chest does
  } accelerometer;
  struct PlanVelocity {
    bool enabled = true;
    VelocityAxes axes = VelocityAxes::robot;
    double sigma_m_s = 0.01;  ///< of single frames, swaying apart
    bool pivots_on_foot =
        true;  ///< turning unknown to the plan is about the support foot (robot's axes only)
    double standing_factor = 1;        ///< of sigma_m_s while the plan stands still
    double double_support_factor = 1;  ///< likewise while it has both feet on the ground
    double landing_factor = 1;         ///< likewise for landing_s after it has set a foot down
    double landing_s = 0.1;
    double sigma_per_turn_m = 0;  ///< added for each rad/s that it turns
    double sigma_slip_m_s = 0;    ///< of the slowly changing part of the plan's error; 0 = there is none
    double slip_time_s = 10;      ///< how long that part lasts
    double sigma_stride =
        0.008;                  ///< part by which its strides are wrong for long, in length and aside; 0: not
    double stride_time_s = 30;  ///< how long
    double sigma_sway_m_s = 0.03;  ///< of swaying aside that the plan does not know of; 0 = there is none
    double sway_ahead = 0.6, sway_up = 0.15;  ///< parts of that: of swaying ahead, and up
    double sway_period_s = 1.6;               ///< of that swaying: two steps
    double sway_time_s = 1;                   ///< how long it goes on undisturbed
  } plan_velocity;
  struct Height {
    bool enabled = true;
    double sigma_m = 0.03;
  } height;
  struct PlanOrientation {  ///< drifts as the feet slip, hence off
    bool enabled = false;
    double sigma_rad = 0.005;
  } plan_orientation;
  struct PlanPosition {  ///< likewise
    bool enabled = false;
    double sigma_m = 0.02;
  } plan_position;
  struct Vision {
    bool enabled = true;
    /// At the image's centre; grows linearly to twice that at the corner. Above the scatter of single
    /// matches, because their errors last over some frames.
    double sigma_px = 0.25;
    /// Likewise of the pixel of the first sight: the template cut out there is what the landmark is, so that
    /// only what later matches have in common against it is left.
    double sigma_first_px = 0.12;
    /// What a patch takes for its centre changes with the view: by so much (1 sigma) after the camera has
    /// moved by the landmark's distance, its square in proportion to the way; 0 = it does not.
    double sigma_view_px = 0.25;
    double gate_sigma_px = 0.15;  ///< scatter of a single right match, likewise: wrong ones are told by it
    int visible_landmarks = 12;   ///< how many to keep in view
    int measured_landmarks = 12;  ///< how many of them to measure in a frame, the least certain ones
    double minimum_correlation = 0.8;
    double corner_threshold =
        20000;                   ///< smaller eigenvalue of the 11x11 gradient moments, grey levels squared
    bool warped_patches = true;  ///< as the predicted view should show them; else as first seen
    bool estimate_normals =
        true;               ///< of the landmarks' surfaces, for warping; else they face the first sight
    bool sub_pixel = true;  ///< matches refined below the pixel
    bool consensus = true;  ///< only matches that agree among themselves are used
  } vision;
  struct Tracking {
    double lost_after_s = 2;   ///< of images in which almost nothing is found
    double vision_bound = 3;   ///< mean NIS of 15 frames' matches per degree of freedom; beyond, it is lost
    double height_bound = 10;  ///< likewise of the planned height
    bool relocalise = true;    ///< when lost, the map is looked for in the whole image; else it is the end
    double give_up_s = 10;     ///< of images in which it was not found
  } tracking;
  struct Depth {  ///< of a landmark at first sight
    FirstSight first_sight = FirstSight::inverse_depth;
    double inverse_1_m = 0.3, sigma_inverse_1_m = 0.3;
    double linearity = 0.25;  ///< a landmark becomes a point below this linearity index; 0 = never
    struct Particles {  ///< Davison et al. 2007 have 100 from 0.5 to 5 m, for things near a hand-held camera
      int count = 100;
      double nearest_m = 0.5, furthest_m = 12;
      double converged = 0.3;  ///< it becomes a point when the depth's deviation is this part of its mean
      int fewest = 20;         ///< particles, below which the line is given up
      int attempts = 10;       ///< frames, after which it is given up
      int at_once = 1;         ///< lines in the map
      double minimum_speed_m_s = 0.05;  ///< slower than this no line is begun
    } particles;
  } depth;
  struct KnownLandmarks {  ///< corners looked for in the first image, and points of the map from then on
    std::vector<Eigen::Vector3d> at_m;  ///< in W
    double sigma_m = 0.005;
  } known_landmarks;
  struct Consistency {
    bool observability_constrained =
        true;  ///< no measurement may seem to tell the heading of the whole world
  } consistency;
};

}  // namespace slam
