// The filter's input: one struct used by live runs, replay, sensor errors, recordings and tests.
#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace slam {

/// Time since the start of the run, by the clock of the simulation or the robot.
using Stamp = std::chrono::nanoseconds;

/// A stamp, or the difference of two, in s.
inline double seconds(Stamp t) { return std::chrono::duration<double>(t).count(); }

/// Gravity in the filter, m/s².
inline constexpr double kGravity = 9.81;

/// The standard deviations of the gyro and accelerometer options refer to readings of this period, s.
inline constexpr double kReadingPeriod_s = 0.005;

/// One inertial reading: the mean over (begin, end]. Successive readings are contiguous, so that a gap is
/// visible. A camera frame splits the 200 Hz reading during which it is taken. Axes: G, the chest IMU.
struct InertialSample {
  Stamp begin{0};
  Stamp end{0};
  Eigen::Vector3d value =
      Eigen::Vector3d::Zero();  ///< gyro: rad/s; accelerometer: specific force, m/s² (+g upward at rest)
};

/// Which feet are on the ground according to the walking plan.
enum class Support { both, left, right };

/// The camera pose from leg odometry at the time of a frame, computed from the joint encoders and the loaded
/// sole, which is assumed to be stationary. O is the odometry's world. It equals W at the start and drifts as
/// the soles slip and tilt.
struct LegMotion {
  Eigen::Isometry3d X_OC = Eigen::Isometry3d::Identity();
  Eigen::Vector3d p_CS = Eigen::Vector3d::Zero();  ///< the loaded sole, m in C
  std::optional<Eigen::Isometry3d> X_CG = {};      ///< chest IMU from the encoders; nothing: as calibrated
};

/// The camera's motion at the time of the frame as planned by the pattern generator, in the plan's own world
/// P, which equals W at the start and drifts from it as the feet slip. X_PC maps points from C to P. v_PC_C,
/// w_PC_C: planned linear (m/s) and angular (rad/s) velocity of the camera in P, expressed in C.
struct PlannedMotion {
  Eigen::Isometry3d X_PC = Eigen::Isometry3d::Identity();
  Eigen::Vector3d v_PC_C = Eigen::Vector3d::Zero();
  Eigen::Vector3d w_PC_C = Eigen::Vector3d::Zero();
  /// The planned sole of the support foot, about which the robot tilts, or the midpoint of both soles; m in
  /// C.
  Eigen::Vector3d p_CF = Eigen::Vector3d::Zero();
  Support support = Support::both;
};

/// The commanded velocity of the base, in its own heading.
struct CommandedVelocity {
  Stamp t{0};  ///< when it was commanded
  double ahead_m_s = 0, left_m_s = 0, turn_rad_s = 0;
};

/// A point that a lidar measured, in the lidar's frame at the time of the point.
struct LidarPoint {
  float x_m = 0, y_m = 0, z_m = 0;
  float intensity = 0;         ///< 0-1: fraction of the light that the surface returns
  std::int32_t offset_ns = 0;  ///< time since the stamp of the sweep
};

/// A reading of one additional sensor of the rig: an image, a sweep or an inertial reading. The filter uses
/// only an aligned depth image (Calibration::depth).
struct RigReading {
  int sensor = 0;  ///< index in the list of the rig's sensors
  Stamp t{0};      ///< image: middle of its exposure; sweep: its start; IMU: end of the interval
  /// 8-bit gray (CV_8UC1), RGB (CV_8UC3), or depth along the optical axis in mm (CV_16UC1; 0: none).
  cv::Mat image;
  std::vector<LidarPoint> points;
  Stamp begin{0};                                           ///< IMU: start of the interval
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();           ///< rad/s, mean over the interval
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  ///< specific force, m/s², mean over the interval
};

/// Readings of the joints' encoders and of the force sensors of both feet at one instant. The filter ignores
/// them and uses leg odometry instead.
struct BodyReading {
  struct Wrench {
    Eigen::Vector3d force = Eigen::Vector3d::Zero(),  ///< N
        torque = Eigen::Vector3d::Zero();             ///< N·m about the point of the sole below the ankle
  };
  Stamp t{0};
  Eigen::VectorXd q;   ///< rad, one for each joint
  Wrench left, right;  ///< exerted by the ground on each foot, axes of the sole
};

/// One camera frame and all measurements since the previous one. A missing measurement is an empty image, an
/// empty vector or no plan. Plan, leg odometry and command do not depend on each other.
struct Observation {
  Stamp t{0};
  cv::Mat image;  ///< 8-bit gray (CV_8UC1) of the camera's size; empty if the frame is lost
  std::vector<InertialSample> gyro;           ///< readings since the previous frame, in chronological order
  std::vector<InertialSample> accelerometer;  ///< readings since the previous frame, in chronological order
  std::optional<PlannedMotion> plan;
  std::optional<LegMotion> legs;
  std::optional<CommandedVelocity> command;  ///< the newest
  /// Completed since the previous frame, in chronological order for each sensor.
  std::vector<RigReading> rig;
  std::vector<BodyReading> body;  ///< at or after the previous frame, before this one; in chronological order
};

}  // namespace slam
