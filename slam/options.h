// What can be set in the filter, with defaults, ranges and meanings; the scenario's keys slam.* are these.
// `keys` tells a visitor with number, choice, value and part the name, range and meaning of each option.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string_view>
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
inline constexpr std::array<std::string_view, 2> kVelocityAxes{"robot", "plan"};

/// Which gyro readings of a frame interval are used: all of them, or the last alone, as the paper's.
enum class GyroReadings { all, last };
inline constexpr std::array<std::string_view, 2> kGyroReadings{"all", "last"};

/// How a landmark is in the state from its first sight on: by inverse depth, or as a semi-infinite line with
/// depth particles that becomes a point later, as the paper's.
enum class FirstSight { inverse_depth, particles };
inline constexpr std::array<std::string_view, 2> kFirstSights{"inverse_depth", "particles"};

struct Options {
  struct Start {  ///< covers the robot's settling on its feet
    double sigma_position_m = 0.001, sigma_orientation_rad = 0.002, sigma_velocity_m_s = 0.05,
           sigma_rate_rad_s = 0.05;
    double sigma_rest_rad_s = 0.01;

    static void keys(auto&& key) {
      key.number("sigma_position_m", &Start::sigma_position_m, 1e-9, 1e6,
                 "standard deviation of the first position");
      key.number("sigma_orientation_rad", &Start::sigma_orientation_rad, 1e-9, 1e6,
                 "standard deviation of the first orientation");
      key.number("sigma_velocity_m_s", &Start::sigma_velocity_m_s, 1e-9, 1e6,
                 "standard deviation of the first velocity");
      key.number("sigma_rate_rad_s", &Start::sigma_rate_rad_s, 1e-9, 1e6,
                 "standard deviation of the first angular velocity");
      key.number("sigma_rest_rad_s", &Start::sigma_rest_rad_s, 0, 1e6,
                 "standard deviation of a frame's angular velocity as long as the plan has not moved yet, which tells the "
                 "gyro's bias; 0: standing still is not used");
    }
  } start;

  struct Motion {  ///< constant-velocity model
    double sigma_acceleration_m_s2 = 4.0, sigma_angular_acceleration_rad_s2 = 6.0;

    static void keys(auto&& key) {
      key.number("sigma_acceleration_m_s2", &Motion::sigma_acceleration_m_s2, 1e-9, 1e6,
                 "standard deviation of the camera's unknown acceleration");
      key.number("sigma_angular_acceleration_rad_s2", &Motion::sigma_angular_acceleration_rad_s2, 1e-9, 1e6,
                 "standard deviation of the camera's unknown angular acceleration");
    }
  } motion;

  struct Gyro {
    bool enabled = true;
    GyroReadings readings = GyroReadings::all;
    double sigma_rad_s = 0.01;
    double sigma_bias_rad_s = 0.01;
    double sigma_bias_walk_rad_s2 = 0;

    static void keys(auto&& key) {
      key.value("enabled", &Gyro::enabled, "whether the filter uses the gyro");
      key.choice(
          "readings", &Gyro::readings, kGyroReadings,
          "gyro readings of a frame interval that the filter uses: all of them, or the last one alone");
      key.number("sigma_rad_s", &Gyro::sigma_rad_s, 1e-9, 1e6,
                 "standard deviation that the filter assumes for a 200 Hz gyro reading");
      key.number("sigma_bias_rad_s", &Gyro::sigma_bias_rad_s, 0, 1e3,
                 "standard deviation of the gyro's bias at the start; 0: the filter assumes no bias");
      key.number(
          "sigma_bias_walk_rad_s2", &Gyro::sigma_bias_walk_rad_s2, 0, 1e3,
          "random walk that the filter assumes for the gyro's bias: growth of its standard deviation in 1 s");
    }
  } gyro;

  /// The bias covers the mounting's error of 1.5 mrad too, which looks alike.
  struct Accelerometer {
    bool enabled = true;
    double sigma_m_s2 = 0.05;
    double sigma_bias_m_s2 = 0.015;
    double sigma_bias_walk_m_s3 = 0.01;
    double sigma_frame_m_s2 = 0.1;

    static void keys(auto&& key) {
      key.value("enabled", &Accelerometer::enabled, "whether the motion model uses the accelerometer");
      key.number("sigma_m_s2", &Accelerometer::sigma_m_s2, 1e-9, 1e6,
                 "standard deviation that the filter assumes for a 200 Hz accelerometer reading");
      key.number(
          "sigma_bias_m_s2", &Accelerometer::sigma_bias_m_s2, 0, 1e3,
          "standard deviation of the accelerometer's bias at the start; 0: the filter assumes no bias");
      key.number("sigma_bias_walk_m_s3", &Accelerometer::sigma_bias_walk_m_s3, 0, 1e3,
                 "random walk that the filter assumes for the accelerometer's bias: growth of its standard "
                 "deviation in "
                 "1 s");
      key.number(
          "sigma_frame_m_s2", &Accelerometer::sigma_frame_m_s2, 0, 1e3,
          "standard deviation of the difference, in each frame interval, between the head's acceleration and "
          "the chest's");
    }
  } accelerometer;

  struct PlanVelocity {
    bool enabled = true;
    VelocityAxes axes = VelocityAxes::robot;
    bool pivots_on_foot = true;
    double sigma_m_s = 0.02;
    double standing_factor = 1;
    double double_support_factor = 1;
    double landing_factor = 1;
    double landing_s = 0.1;
    double sigma_per_turn_m = 0;
    double sigma_slip_m_s = 0;
    double slip_time_s = 10;
    double sigma_stride = 0.008;
    double stride_time_s = 30;
    double sigma_sway_m_s = 0.03;
    double sway_ahead = 0.6, sway_up = 0.15;
    double sway_period_s = 1.6;
    double sway_time_s = 1;

    static void keys(auto&& key) {
      key.value("enabled", &PlanVelocity::enabled, "whether the filter uses the planned velocity");
      key.choice(
          "axes", &PlanVelocity::axes, kVelocityAxes,
          "axes along which the planned velocity is used: the robot's own or those of the plan's world");
      key.value(
          "pivots_on_foot", &PlanVelocity::pivots_on_foot,
          "whether rotation unknown to the plan is about the support foot (with the robot's axes only)");
      key.number("sigma_m_s", &PlanVelocity::sigma_m_s, 1e-9, 1e6,
                 "standard deviation that the filter assumes for the planned velocity of a frame");
      key.number("standing_factor", &PlanVelocity::standing_factor, 1e-3, 1e3,
                 "factor on plan_velocity.sigma_m_s while the plan stands still");
      key.number("double_support_factor", &PlanVelocity::double_support_factor, 1e-3, 1e3,
                 "factor on plan_velocity.sigma_m_s while the plan has both feet on the ground");
      key.number("landing_factor", &PlanVelocity::landing_factor, 1e-3, 1e3,
                 "factor on plan_velocity.sigma_m_s just after the plan has set a foot down");
      key.number("landing_s", &PlanVelocity::landing_s, 0, 10,
                 "time after a landing for which landing_factor holds");
      key.number("sigma_per_turn_m", &PlanVelocity::sigma_per_turn_m, 0, 1e3,
                 "increase of plan_velocity.sigma_m_s for each rad/s of the planned rotation");
      key.number(
          "sigma_slip_m_s", &PlanVelocity::sigma_slip_m_s, 0, 1e3,
          "standard deviation of a slowly changing error of the planned velocity (slip); 0: there is none");
      key.number("slip_time_s", &PlanVelocity::slip_time_s, 0.001, 1e6,
                 "correlation time of the slowly changing error of the planned velocity");
      key.number(
          "sigma_stride", &PlanVelocity::sigma_stride, 0, 1e3,
          "standard deviation of a lasting error of the planned strides, relative, in length and sideways; "
          "0: there is none");
      key.number("stride_time_s", &PlanVelocity::stride_time_s, 1e-3, 1e6,
                 "correlation time of the lasting error of the planned strides");
      key.number("sigma_sway_m_s", &PlanVelocity::sigma_sway_m_s, 0, 1e3,
                 "standard deviation of the lateral sway velocity that is not in the plan; 0: there is none");
      key.number("sway_ahead", &PlanVelocity::sway_ahead, 0, 10,
                 "sway velocity in the direction of walking, relative to the lateral one");
      key.number("sway_up", &PlanVelocity::sway_up, 0, 10,
                 "vertical sway velocity, relative to the lateral one");
      key.number("sway_period_s", &PlanVelocity::sway_period_s, 1e-3, 1e6,
                 "period of the sway, which is the time of two steps");
      key.number("sway_time_s", &PlanVelocity::sway_time_s, 1e-3, 1e6,
                 "correlation time of the sway's amplitude and phase");
    }
  } plan_velocity;

  /// Where the robot measures how its legs moved the camera, that takes the place of the planned velocity
  /// along the robot's axes, and these noises the place of those of plan_velocity: of the sways and strides
  /// that are not in the plan little is left.
  struct LegOdometry {
    bool enabled = true;
    double sigma_m_s = 0.008, landing_factor = 6, landing_s = 0.2;
    double sigma_stride = 0.005, sigma_sway_m_s = 0.005;

    static void keys(auto&& key) {
      key.value("enabled", &LegOdometry::enabled,
                "whether leg odometry, where it is given, takes the place of the planned velocity");
      key.number("sigma_m_s", &LegOdometry::sigma_m_s, 1e-9, 1e6,
                 "standard deviation that the filter assumes for the velocity of a frame by leg odometry");
      key.number("landing_factor", &LegOdometry::landing_factor, 1e-3, 1e3,
                 "factor on leg_odometry.sigma_m_s just after the plan has set a foot down");
      key.number("landing_s", &LegOdometry::landing_s, 0, 10,
                 "time after a landing for which leg_odometry.landing_factor holds");
      key.number("sigma_stride", &LegOdometry::sigma_stride, 0, 1e3,
                 "standard deviation of a lasting error of leg odometry, relative, in length and sideways");
      key.number("sigma_sway_m_s", &LegOdometry::sigma_sway_m_s, 0, 1e3,
                 "standard deviation of the lateral sway velocity that leg odometry does not measure");
    }
  } leg_odometry;

  struct Height {
    bool enabled = true;
    double sigma_m = 0.03;

    static void keys(auto&& key) {
      key.value("enabled", &Height::enabled, "whether the filter uses the planned height");
      key.number("sigma_m", &Height::sigma_m, 1e-9, 1e6,
                 "standard deviation that the filter assumes for the planned height");
    }
  } height;

  struct PlanOrientation {  ///< drifts as the feet slip, hence off
    bool enabled = false;
    double sigma_rad = 0.005;

    static void keys(auto&& key) {
      key.value("enabled", &PlanOrientation::enabled, "whether the filter uses the planned orientation");
      key.number("sigma_rad", &PlanOrientation::sigma_rad, 1e-9, 1e6,
                 "standard deviation that the filter assumes for the planned orientation");
    }
  } plan_orientation;

  struct PlanPosition {  ///< drifts as the feet slip, hence off
    bool enabled = false;
    double sigma_m = 0.02;

    static void keys(auto&& key) {
      key.value("enabled", &PlanPosition::enabled, "whether the filter uses the planned position");
      key.number("sigma_m", &PlanPosition::sigma_m, 1e-9, 1e6,
                 "standard deviation that the filter assumes for the planned position");
    }
  } plan_position;

  /// Image noise grows linearly from the centre to twice that at the corner; sigma_px is above the scatter of
  /// single matches, because their errors last over some frames. sigma_first_px: the template cut out at the
  /// first sight is what the landmark is, so that only what later matches have in common against it is left.
  /// sigma_view_px: the square grows in proportion to the way. corner_threshold: of the 11x11 gradient
  /// moments, grey levels squared.
  struct Vision {
    bool enabled = true;
    double sigma_px = 0.25;
    double sigma_first_px = 0.12;
    double sigma_view_px = 0.3;
    double sigma_lasting_px = 0.2;
    double lasting_s = 3;
    double gate_sigma_px = 0.15;
    int visible_landmarks = 18;
    int measured_landmarks = 12;
    double minimum_correlation = 0.9;
    double corner_threshold = 20000;
    bool warped_patches = true;
    bool estimate_normals = true;
    bool sub_pixel = true;
    bool consensus = true;

    static void keys(auto&& key) {
      key.value("enabled", &Vision::enabled, "whether the filter uses the camera");
      key.number("sigma_px", &Vision::sigma_px, 0.01, 100,
                 "standard deviation of a match at the image's centre; twice that at the corner");
      key.number("sigma_first_px", &Vision::sigma_first_px, 0.001, 100,
                 "standard deviation of the pixel at which a landmark was first seen, at the image's centre");
      key.number(
          "sigma_view_px", &Vision::sigma_view_px, 0, 100,
          "standard deviation of the shift of a patch's apparent centre once the camera has moved by the "
          "landmark's distance");
      key.number("sigma_lasting_px", &Vision::sigma_lasting_px, 0, 100,
                 "standard deviation of the part of a match's error that lasts over frames, at the image's centre; 0: there "
                 "is none");
      key.number("lasting_s", &Vision::lasting_s, 1e-3, 1e6,
                 "correlation time of the part of a match's error that lasts");
      key.number("gate_sigma_px", &Vision::gate_sigma_px, 0.01, 100,
                 "standard deviation of a single correct match, by which wrong matches are gated");
      key.number("visible_landmarks", &Vision::visible_landmarks, 1, 1000,
                 "number of landmarks to keep in view");
      key.number("measured_landmarks", &Vision::measured_landmarks, 1, 1000,
                 "number of landmarks to measure in a frame, the least certain of those in view");
      key.number("minimum_correlation", &Vision::minimum_correlation, -1, 1,
                 "least normalised correlation of a match");
      key.number("corner_threshold", &Vision::corner_threshold, 0, 1e9,
                 "least smaller eigenvalue of the gradient moments of a corner");
      key.value("warped_patches", &Vision::warped_patches,
                "whether templates are warped to the predicted view; otherwise they stay as first seen");
      key.value(
          "estimate_normals", &Vision::estimate_normals,
          "whether the normals of the landmarks' surfaces are estimated; otherwise they face the first view");
      key.value("sub_pixel", &Vision::sub_pixel, "whether matches are refined below the pixel");
      key.value("consensus", &Vision::consensus, "whether only consistent matches are used (1-point RANSAC)");
    }
  } vision;

  struct Tracking {
    double lost_after_s = 2;
    double vision_bound = 3;
    double height_bound = 10;
    bool relocalise = true;
    double give_up_s = 10;
    double plan_bound = 4;
    double lens_bound = 6;

    static void keys(auto&& key) {
      key.number("lost_after_s", &Tracking::lost_after_s, 1e-3, 1e6,
                 "time without a usable image, or with almost no landmark found, after which tracking is lost");
      key.number("vision_bound", &Tracking::vision_bound, 1e-3, 1e9,
                 "mean NIS of 15 frames' matches, per degree of freedom, above which tracking is lost");
      key.number("height_bound", &Tracking::height_bound, 1e-3, 1e9,
                 "mean NIS of 15 frames' planned heights above which tracking is lost");
      key.value("relocalise", &Tracking::relocalise,
                "whether a lost filter searches the whole image for its map; otherwise it has diverged");
      key.number("give_up_s", &Tracking::give_up_s, 1e-3, 1e6,
                 "time for which tracking may be lost, after which the filter has diverged");
      key.number("plan_bound", &Tracking::plan_bound, 1e-3, 1e9,
                 "number of standard deviations by which the innovations must contradict planned distances that are right "
                 "within 2 % for the plan to be suspect");
      key.number("lens_bound", &Tracking::lens_bound, 1e-3, 1e9,
                 "number of standard deviations by which the innovations must contradict a lens distortion that is right "
                 "within 2 % for the images to be suspect");
    }
  } tracking;

  /// What a frame may cost at most, whatever the other options ask for.
  struct Bounds {
    int landmarks = 300;
    int measured = 100;
    int searched_px = 400000;
    double memory_mb = 256;

    static void keys(auto&& key) {
      key.number("landmarks", &Bounds::landmarks, 1, 10000,
                 "greatest number of landmarks in the map; those out of view that were found least often make "
                 "room for new ones");
      key.number("measured", &Bounds::measured, 1, 1000,
                 "greatest number of landmarks measured in a frame, however large vision.measured_landmarks is");
      key.number("searched_px", &Bounds::searched_px, 6561, 1000000000,
                 "greatest number of pixels at which templates are compared in a frame; the least informative "
                 "landmarks are then not searched for");
      key.number("memory_mb", &Bounds::memory_mb, 1, 1e6,
                 "greatest memory of the state's covariance, in 10^6 bytes, to which the map is held too");
    }
  } bounds;

  struct Depth {
    FirstSight first_sight = FirstSight::inverse_depth;
    double inverse_1_m = 0.3, sigma_inverse_1_m = 0.3;
    double linearity = 0.25;

    struct Particles {  ///< Davison et al. 2007 have 100 from 0.5 to 5 m, for things near a hand-held camera
      int count = 100;
      double nearest_m = 0.5, furthest_m = 12;
      double converged = 0.3;
      int fewest = 20;
      int attempts = 10;
      int at_once = 1;
      double minimum_speed_m_s = 0.05;

      static void keys(auto&& key) {
        key.number("count", &Particles::count, 2, 10000,
                   "number of depth particles along a new landmark's ray");
        key.number("nearest_m", &Particles::nearest_m, 0.01, 1000, "depth of the nearest particle");
        key.number("furthest_m", &Particles::furthest_m, 0.02, 1000, "depth of the furthest particle");
        key.number(
            "converged", &Particles::converged, 0.001, 1,
            "standard deviation of the depth, relative to its mean, below which a ray becomes a point");
        key.number("fewest", &Particles::fewest, 1, 10000,
                   "number of particles below which a ray is discarded");
        key.number("attempts", &Particles::attempts, 1, 100000,
                   "number of frames after which a ray is discarded");
        key.number("at_once", &Particles::at_once, 1, 1000, "greatest number of rays in the map at a time");
        key.number("minimum_speed_m_s", &Particles::minimum_speed_m_s, 0, 1e3,
                   "camera speed below which no ray is initialised");
      }
    } particles;

    static void keys(auto&& key) {
      key.choice("first_sight", &Depth::first_sight, kFirstSights,
                 "initialisation of a landmark: by inverse depth, or as a ray with depth particles");
      key.number("inverse_1_m", &Depth::inverse_1_m, 1e-6, 100, "inverse depth of a new landmark");
      key.number("sigma_inverse_1_m", &Depth::sigma_inverse_1_m, 1e-6, 100,
                 "standard deviation of a new landmark's inverse depth");
      key.number("linearity", &Depth::linearity, 0, 10,
                 "linearity index below which an inverse-depth landmark becomes a point; 0: it never does");
      key.part("particles", &Depth::particles);
    }
  } depth;

  struct KnownLandmarks {  ///< corners looked for in the first image, and points of the map from then on
    std::vector<Eigen::Vector3d> at_m;  ///< in W
    double sigma_m = 0.005;

    static void keys(auto&& key) {
      key.number("at_m", &KnownLandmarks::at_m, -1000, 1000,
                 "world positions of corners known beforehand, which are searched for in the first image");
      key.number("sigma_m", &KnownLandmarks::sigma_m, 1e-6, 10,
                 "standard deviation of the positions of the known landmarks");
    }
  } known_landmarks;

  struct Consistency {
    bool observability_constrained = true;

    static void keys(auto&& key) {
      key.value(
          "observability_constrained", &Consistency::observability_constrained,
          "whether updates are kept from adding false information about the heading, which is unobservable");
    }
  } consistency;

  static void keys(auto&& key) {
    key.part("start", &Options::start);
    key.part("motion", &Options::motion);
    key.part("gyro", &Options::gyro);
    key.part("accelerometer", &Options::accelerometer);
    key.part("plan_velocity", &Options::plan_velocity);
    key.part("leg_odometry", &Options::leg_odometry);
    key.part("height", &Options::height);
    key.part("plan_orientation", &Options::plan_orientation);
    key.part("plan_position", &Options::plan_position);
    key.part("vision", &Options::vision);
    key.part("tracking", &Options::tracking);
    key.part("bounds", &Options::bounds);
    key.part("depth", &Options::depth);
    key.part("known_landmarks", &Options::known_landmarks);
    key.part("consistency", &Options::consistency);
  }
};

}  // namespace slam
