// The sensor.yaml files of a recording: where sensors are mounted, and intrinsics of the cameras.
#pragma once

#include "sim/recording/recording_format.h"

namespace sim::recording {

/// White noise per root hertz and random walk of the bias, as stated in calibration files.
struct ImuNoise {
  double gyro_density = 0;           ///< rad/s/√Hz
  double gyro_walk = 0;              ///< rad/s²/√Hz
  double accelerometer_density = 0;  ///< m/s²/√Hz
  double accelerometer_walk = 0;     ///< m/s³/√Hz
};

/// Returns the file of cam0. The body frame is the chest IMU G, so T_BS = X_GC; the filter uses T_SB = X_CG.
/// distortion_model: one-parameter-radial (u_d = u_0 + u_c / sqrt(1 + 2 k1 |u_c|²), u_c = (fu x/z, fv y/z),
/// Swaminathan & Nayar 1999), radial-tangential or equidistant.
std::string camera_yaml(const slam::Calibration& calibration, double rate_hz);
/// Returns the file of an IMU. begin: start of the first interval, if readings are means.
std::string imu_yaml(const std::string& comment, const Eigen::Isometry3d& X_BS, double rate_hz,
                     const ImuNoise& noise, std::optional<slam::Stamp> begin = {});
std::string body_sensor_yaml(const BodySensor& sensor, const RecordingSetup& setup);
std::string motion_source_yaml(const MotionSource& source, const RecordingSetup& setup);
std::string motion_yaml();
/// Returns the body's file. It lists the additional sensors, if any.
std::string body_yaml(const std::vector<rig::RigSensor>& rig = {});
/// Returns the file of an additional sensor with everything in RigSensor. begin: for an IMU, start of the
/// first interval.
std::string rig_sensor_yaml(const rig::RigSensor& sensor, const slam::Calibration& calibration,
                            std::optional<slam::Stamp> begin = {});

/// A file's name and text. Its readers throw FileError, also if two keys contradict each other. Matrices are
/// maps with 16 numbers in `data`, lists of 16 numbers, or four rows; four digits suffice.
struct YamlFile {
  fs::path name;
  std::string text;
};

/// Values of a camera's file besides the calibration.
struct StatedCamera {
  std::optional<double> rate_hz;          ///< absent only in kalibr files
  double timeshift_s = 0;                 ///< timeshift_cam_imu: the IMU's stamps minus the camera's
  std::optional<Eigen::Isometry3d> X_SB;  ///< the body in the camera's frame (T_SB, T_BS)
  std::optional<Eigen::Isometry3d> X_SI;  ///< the IMU in the camera's frame (T_cam_imu, T_imu_cam)
  std::vector<std::string> unread;        ///< ignored keys
};
/// Reads a sensor.yaml, or cam0 of a kalibr camchain. The calibration's X_CG is X_SB or, if absent, X_SI.
StatedCamera read_camera_yaml(const YamlFile& file, RecordingSetup& setup);
/// An IMU: its mounting on the body and its stated noise (zero if not stated).
struct StatedImu {
  Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();
  ImuNoise noise;
  double rate_hz = 0;
  std::optional<slam::Stamp> begin;  ///< start of the first interval
  std::vector<std::string> unread;   ///< ignored keys
};
/// Reads a sensor.yaml, or kalibr's IMU file, which has update_rate and no T_BS.
StatedImu read_imu_yaml(const YamlFile& file);
/// Reads a pose from its key or from its inverse's key.
Eigen::Isometry3d read_pose(const YamlFile& file, const std::string& key, const std::string& inverse = {});
/// Reads the file of plan0: the start, and whether the floor is level (the default).
void read_plan_yaml(const YamlFile& file, RecordingSetup& setup);
/// Throws FileError if the camera's two poses do not agree with the mounting of the IMU.
void require_same_mounting(const fs::path& camera_file, const StatedCamera& camera, const fs::path& imu_file,
                           const StatedImu& imu);
/// Reads the names of the joints, or of the additional sensors.
std::vector<std::string> read_joints(const YamlFile& file);
std::vector<std::string> read_body_yaml(const YamlFile& file);
/// Reads an additional sensor, and `begin` as in rig_sensor_yaml().
std::pair<rig::RigSensor, std::optional<slam::Stamp>> read_rig_sensor_yaml(const YamlFile& file,
                                                                           const std::string& name);

}  // namespace sim::recording
