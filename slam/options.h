// Options of the filter with their defaults, ranges and meanings: the keys under slam in a scenario.
// `keys` passes each of them to a visitor: number<&Gyro::sigma_rad_s>(visitor, lowest, highest, meaning),
// which the visitor's namespace declares.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
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

/// Kannala & Brandt 2006: the image radius is f (θ + k1 θ³ + k2 θ⁵ + k3 θ⁷ + k4 θ⁹), θ being the angle from
/// the axis (OpenCV's fisheye; Kalibr's "equidistant").
struct Equidistant {
  double k1 = 0, k2 = 0, k3 = 0, k4 = 0;
};

using Lens = std::variant<OneParameterRadial, RadialTangential, Equidistant>;

/// z forward, u right, v down; the center of the first pixel is (0, 0).
struct CameraIntrinsics {
  int width_px = 320, height_px = 240;
  double fu_px = 197.0, fv_px = 195.0, u0_px = 157.0, v0_px = 127.0;
  Lens lens = OneParameterRadial{7.37e-6};
};

/// A depth camera with the pixels and stamps of the head camera. It measures disparities, so the error of the
/// inverse depth 1/z (z along the optical axis) is the same at all depths.
struct AlignedDepth {
  int sensor = 0;  ///< RigReading::sensor
  double sigma_inverse_1_m = 0;
};

/// The mounting of the sensors, known to the filter as on a real robot.
struct Calibration {
  CameraIntrinsics camera;
  Eigen::Isometry3d X_CG = Eigen::Isometry3d::Identity();  ///< chest IMU in the camera's frame
  std::optional<AlignedDepth> depth = {};
  bool level_floor = true;  ///< the robot walks on the plane z = 0, as far as it knows
};

/// The axes along which the planned velocity is measured: the robot's or the plan's world's.
enum class VelocityAxes { robot, plan };
inline constexpr std::array<std::string_view, 2> kVelocityAxes{"robot", "plan"};

/// Which gyro readings of a frame interval are used: all, or only the last one, as in the paper.
enum class GyroReadings { all, last };
inline constexpr std::array<std::string_view, 2> kGyroReadings{"all", "last"};

/// The parameters of a new landmark: inverse depth, or the paper's semi-infinite line with depth particles.
/// measured_depth: inverse depth, starting from the depth camera's reading if the pixel has one.
enum class FirstSight { inverse_depth, particles, measured_depth };
inline constexpr std::array<std::string_view, 3> kFirstSights{"inverse_depth", "particles", "measured_depth"};

/// The pose at the start in a loaded map: known to 5 cm and 3 degrees, to 0.5 m and 20 degrees, or not at
/// all.
enum class MapStart { known, rough, unknown };
inline constexpr std::array<std::string_view, 3> kMapStarts{"known", "rough", "unknown"};

struct Options {
  struct Start {  ///< covers the robot's settling on its feet
    double sigma_position_m = 0.0017, sigma_orientation_rad = 0.002;
    double sigma_velocity_m_s = 0.05, sigma_rate_rad_s = 0.05;
    double sigma_rest_rad_s = 0.01;
    static void keys(auto&& key) {
      number<&Start::sigma_position_m>(key, 1e-9, 1e6, "standard deviation of the initial position");
      number<&Start::sigma_orientation_rad>(key, 1e-9, 1e6, "standard deviation of the initial orientation");
      number<&Start::sigma_velocity_m_s>(key, 1e-9, 1e6, "standard deviation of the initial velocity");
      number<&Start::sigma_rate_rad_s>(key, 1e-9, 1e6, "standard deviation of the initial angular velocity");
      number<&Start::sigma_rest_rad_s>(
          key, 0, 1e6, "standard deviation of the rate at rest, which reveals the gyro's bias; 0: unused");
    }
  } start;

  struct Motion {  ///< constant-velocity model
    double sigma_acceleration_m_s2 = 4.0, sigma_angular_acceleration_rad_s2 = 6.0;
    static void keys(auto&& key) {
      number<&Motion::sigma_acceleration_m_s2>(key, 1e-9, 1e6,
                                               "standard deviation of the camera's acceleration");
      number<&Motion::sigma_angular_acceleration_rad_s2>(
          key, 1e-9, 1e6, "standard deviation of the camera's angular acceleration");
    }
  } motion;

  struct Gyro {
    bool enabled = true;
    GyroReadings readings = GyroReadings::all;
    double sigma_rad_s = 0.01;
    double sigma_bias_rad_s = 0.01, sigma_bias_walk_rad_s2 = 0;
    bool drives_motion = true;
    /// Standard deviation of the head's rate relative to the chest, if drives_motion.
    static constexpr double sigma_head_rad_s = 0.003;
    static void keys(auto&& key) {
      value<&Gyro::enabled>(key, "whether the filter uses the gyro");
      choice<&Gyro::readings>(key, kGyroReadings, "which readings of a frame interval the filter uses");
      number<&Gyro::sigma_rad_s>(key, 1e-9, 1e6, "assumed standard deviation of a 200 Hz reading");
      number<&Gyro::sigma_bias_rad_s>(key, 0, 1e3, "standard deviation of its bias at the start; 0: no bias");
      number<&Gyro::sigma_bias_walk_rad_s2>(key, 0, 1e3,
                                            "growth of the standard deviation of its bias in 1 s");
      value<&Gyro::drives_motion>(
          key,
          "whether the readings drive the motion model; otherwise they are measurements, as in the paper");
    }
  } gyro;

  struct Accelerometer {  ///< the bias also covers a mounting error of 1.5 mrad, which looks the same
    bool enabled = true;
    double sigma_m_s2 = 0.05;
    double sigma_bias_m_s2 = 0.015, sigma_bias_walk_m_s3 = 0.01;
    /// Standard deviation of the head's acceleration relative to the chest in a frame.
    static constexpr double sigma_head_m_s2 = 0.03;
    static void keys(auto&& key) {
      value<&Accelerometer::enabled>(key, "whether the motion model uses the accelerometer");
      number<&Accelerometer::sigma_m_s2>(key, 1e-9, 1e6,
                                         "assumed standard deviation of a 200 Hz specific force");
      number<&Accelerometer::sigma_bias_m_s2>(key, 0, 1e3,
                                              "standard deviation of its bias at the start; 0: none");
      number<&Accelerometer::sigma_bias_walk_m_s3>(key, 0, 1e3,
                                                   "growth of the standard deviation of that bias in 1 s");
    }
  } accelerometer;

  struct PlanVelocity {
    bool enabled = true;
    VelocityAxes axes = VelocityAxes::robot;
    bool pivots_on_foot = true;
    double sigma_m_s = 0.02, sigma_stride = 0.008, sigma_sway_m_s = 0.03;
    double sigma_sway_scale = 0, sway_period_s = 1.6;
    static void keys(auto&& key) {
      value<&PlanVelocity::enabled>(key, "whether the filter uses the planned velocity");
      choice<&PlanVelocity::axes>(key, kVelocityAxes, "axes of the planned velocity");
      value<&PlanVelocity::pivots_on_foot>(
          key, "whether unplanned rotation is assumed to be about the support foot");
      number<&PlanVelocity::sigma_m_s>(key, 1e-9, 1e6, "standard deviation of a frame's planned velocity");
      number<&PlanVelocity::sigma_stride>(
          key, 0, 1e3, "standard deviation of a stride's relative error in both directions; 0: none");
      number<&PlanVelocity::sigma_sway_m_s>(key, 0, 1e3, "standard deviation of the unplanned sway velocity");
      number<&PlanVelocity::sigma_sway_scale>(
          key, 0, 1e3, "standard deviation of the relative error of the planned sway, ahead and to the side");
      number<&PlanVelocity::sway_period_s>(key, 1e-3, 1e6, "period of the sway: the duration of two steps");
    }
  } plan_velocity;

  /// Leg odometry, if there is any, replaces the planned velocity along the robot's axes. These noises then
  /// replace the noises of plan_velocity: leg odometry measures most of the unplanned swaying and of the
  /// stride error. A sole that tilts on its pads turns about a point that is known only to within
  /// centimeters.
  struct LegOdometry {
    bool enabled = true;
    double sigma_position_m = 0.0001, sigma_m_s = 0.001, sigma_stride = 0.003, sigma_sway_m_s = 0.003;
    double sigma_sway_scale = 0.015, sigma_pivot_m = 0.15;
    static void keys(auto&& key) {
      value<&LegOdometry::enabled>(key,
                                   "whether leg odometry, if there is any, replaces the planned velocity");
      number<&LegOdometry::sigma_position_m>(
          key, 0, 1e6, "standard deviation of a frame's position; a velocity has the errors of two frames");
      number<&LegOdometry::sigma_m_s>(
          key, 1e-9, 1e6, "standard deviation of a frame's velocity in addition to the positions' errors");
      number<&LegOdometry::sigma_stride>(
          key, 0, 1e3, "standard deviation of a stride's relative error in both directions");
      number<&LegOdometry::sigma_sway_m_s>(
          key, 0, 1e3, "standard deviation of the sway velocity that leg odometry does not measure");
      number<&LegOdometry::sigma_sway_scale>(
          key, 0, 1e3, "standard deviation of the relative error of the sway, ahead and to the side");
      number<&LegOdometry::sigma_pivot_m>(
          key, 0, 1e3, "standard deviation of the pivot of any tilting that leg odometry does not measure");
    }
  } leg_odometry;

  /// The commanded velocity, which a robot follows with a lag. It is used while there is neither a plan nor
  /// leg odometry, with these noises instead of the noises of plan_velocity; the commanded turn is not used.
  struct Command {
    bool enabled = true;
    double lag_s = 0.3, sigma_m_s = 0.1, sigma_stride = 0.1, sigma_sway_m_s = 0.25;
    static void keys(auto&& key) {
      value<&Command::enabled>(
          key, "whether the filter uses the commanded velocity when there is no plan or leg odometry");
      number<&Command::lag_s>(key, 1e-3, 1e3, "time constant with which the robot follows a command");
      number<&Command::sigma_m_s>(key, 1e-9, 1e6, "standard deviation of a frame's commanded velocity");
      number<&Command::sigma_stride>(
          key, 0, 1e3, "standard deviation of the commanded velocity's relative error in both directions");
      number<&Command::sigma_sway_m_s>(key, 0, 1e3, "standard deviation of the sway velocity");
    }
  } command;

  struct Height {  ///< from leg odometry if used; its error lasts, since floor and pads are uneven
    bool enabled = true;
    double sigma_m = 0.00015, sigma_lasting_m = 0.0015, lasting_s = 3;
    static void keys(auto&& key) {
      value<&Height::enabled>(key, "whether the filter uses the height from leg odometry or the plan");
      number<&Height::sigma_m>(key, 1e-9, 1e6, "standard deviation of the height in a frame");
      number<&Height::sigma_lasting_m>(key, 0, 1e6, "standard deviation of its lasting error; 0: none");
      number<&Height::lasting_s>(key, 1e-3, 1e6, "correlation time of its lasting error");
    }
  } height;

  /// Image noise doubles linearly from the center to the corner. Searches and gates use at least
  /// gate_sigma_px. The template from the first sighting defines the landmark, so sigma_first_px covers only
  /// the error that all later matches share.
  struct Vision {
    bool enabled = true;
    double sigma_px = 0.055, sigma_first_px = 0.12;
    double viewpoint_sigma_px = 0.5;
    double match_bias_sigma_px = 0.2;
    static constexpr double match_bias_s = 3;  ///< correlation time of that bias
    double gate_sigma_px = 0.15;
    int visible_landmarks = 18, measured_landmarks = 12;
    double minimum_correlation = 0.9;
    /// Minimum of the smaller eigenvalue of a corner's 11x11 gradient moments, gray levels squared.
    static constexpr double corner_threshold = 20000;
    /// The standard deviation of a correct match that searches and gates use.
    double search_sigma_px() const { return std::max(sigma_px, gate_sigma_px); }
    bool warped_patches = true, estimate_normals = true, sub_pixel = true, consensus = true;
    static void keys(auto&& key) {
      value<&Vision::enabled>(key, "whether the filter uses the camera");
      number<&Vision::sigma_px>(
          key, 0.01, 100, "standard deviation of a match at the image center; it doubles toward the corners");
      number<&Vision::sigma_first_px>(key, 0.001, 100, "standard deviation of a landmark's first pixel");
      number<&Vision::viewpoint_sigma_px>(
          key, 0, 100, "shift of a patch's center after the camera has moved by the patch's distance");
      number<&Vision::match_bias_sigma_px>(key, 0, 100,
                                           "standard deviation of a match's lasting bias; 0: none");
      number<&Vision::gate_sigma_px>(key, 0.01, 100, "standard deviation of a correct match, for gating");
      number<&Vision::visible_landmarks>(key, 1, 1000, "number of landmarks to keep in view");
      number<&Vision::measured_landmarks>(key, 1, 1000, "number of landmarks to measure in a frame");
      number<&Vision::minimum_correlation>(key, -1, 1, "minimum normalized correlation of a match");
      value<&Vision::warped_patches>(key, "whether templates are warped to the predicted view");
      value<&Vision::estimate_normals>(key, "whether surface normals are estimated");
      value<&Vision::sub_pixel>(key, "whether matches are refined to sub-pixel accuracy");
      value<&Vision::consensus>(key, "whether only consistent matches are used (1-point RANSAC)");
    }
  } vision;

  struct Tracking {
    double lost_after_s = 2, give_up_s = 10;
    double plan_bound = 4, lens_bound = 6;
    static void keys(auto&& key) {
      number<&Tracking::lost_after_s>(key, 1e-3, 1e6,
                                      "time without an image or a match after which tracking is lost");
      number<&Tracking::give_up_s>(key, 1e-3, 1e6,
                                   "time after which a filter that lost track and its pose has diverged");
      number<&Tracking::plan_bound>(key, 1e-3, 1e9,
                                    "standard deviations beyond 2 % at which the plan's scale is suspect");
      number<&Tracking::lens_bound>(
          key, 1e-3, 1e9, "standard deviations beyond 2 % at which the lens's distortion is suspect");
    }
  } tracking;

  struct Bounds {  ///< bounds on the cost of a frame, regardless of the other options
    int landmarks = 300, measured = 100;
    static void keys(auto&& key) {
      number<&Bounds::landmarks>(key, 1, 1000, "maximum number of landmarks in the map");
      number<&Bounds::measured>(key, 1, 1000, "maximum number of landmarks measured in a frame");
    }
  } bounds;

  struct Depth {
    FirstSight first_sight = FirstSight::inverse_depth;
    double inverse_1_m = 0.3, sigma_inverse_1_m = 0.3;
    double linearity = 0.05;

    struct Particles {  ///< Davison et al. 2007 use 100 from 0.5 to 5 m, for objects near a hand-held camera
      int count = 100;
      double nearest_m = 0.5, furthest_m = 12;
      double converged = 0.3;
      static constexpr int fewest = 20;  ///< number below which a ray is discarded
      int attempts = 10, at_once = 1;
      double minimum_speed_m_s = 0.05;
      static void keys(auto&& key) {
        number<&Particles::count>(key, 2, 10000, "number of depth particles along a new landmark's ray");
        number<&Particles::nearest_m>(key, 0.01, 1000, "depth of the nearest particle");
        number<&Particles::furthest_m>(key, 0.02, 1000, "depth of the furthest particle");
        number<&Particles::converged>(key, 0.001, 1,
                                      "relative error of the depth below which a ray becomes a point");
        number<&Particles::attempts>(key, 1, 100000, "maximum number of frames for which a ray is kept");
        number<&Particles::at_once>(key, 1, 1000, "maximum number of rays in the map at a time");
        number<&Particles::minimum_speed_m_s>(key, 0, 1e3, "camera speed below which no ray is initialized");
      }
    } particles;
    static void keys(auto&& key) {
      choice<&Depth::first_sight>(
          key, kFirstSights,
          "how a new landmark starts: with inverse depth, as a ray with depth particles, or with the "
          "inverse of the depth measured by a camera of the rig that is aligned with cam0");
      number<&Depth::inverse_1_m>(key, 1e-6, 100, "inverse depth of a new landmark");
      number<&Depth::sigma_inverse_1_m>(key, 1e-6, 100, "standard deviation of that inverse depth");
      number<&Depth::linearity>(key, 0, 10,
                                "linearity index below which a new landmark becomes a point; 0: never");
      part<&Depth::particles>(key);
    }
  } depth;

  struct KnownLandmarks {  ///< corners searched for in the first image; they stay in the map as points
    std::vector<Eigen::Vector3d> at_m;  ///< in W
    double sigma_m = 0.005;
    static void keys(auto&& key) {
      number<&KnownLandmarks::at_m>(key, -1000, 1000, "corners that are searched for in the first image");
      number<&KnownLandmarks::sigma_m>(key, 1e-6, 10, "standard deviation of their positions");
    }
  } known_landmarks;

  struct Map {  ///< read and written by the caller of the filter
    std::filesystem::path load;
    MapStart start = MapStart::known;
    bool save = false;
    static void keys(auto&& key) {
      value<&Map::load>(
          key,
          "map of an earlier session to start from: the file map.bin of a result, relative to the "
          "scenario's file; empty: none");
      choice<&Map::start>(key, kMapStarts,
                          "how well the start is known in that map: known (5 cm, 3 deg), rough (0.5 m, 20 "
                          "deg), or unknown");
      value<&Map::save>(key, "whether the result contains the map, as map.bin, for a later session");
    }
  } map;

  struct Consistency {
    bool observability_constrained = true;
    static void keys(auto&& key) {
      value<&Consistency::observability_constrained>(
          key, "whether updates add no false information about the heading");
    }
  } consistency;

  static void keys(auto&& key) {
    part<&Options::start, &Options::motion, &Options::gyro, &Options::accelerometer, &Options::plan_velocity,
         &Options::leg_odometry, &Options::command, &Options::height, &Options::vision, &Options::tracking,
         &Options::bounds, &Options::depth, &Options::known_landmarks, &Options::map, &Options::consistency>(
        key);
  }
};

}  // namespace slam
