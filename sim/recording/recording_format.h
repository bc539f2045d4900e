// The format of a recording's files, shared by its writer and its readers: names, column titles and rows.
#pragma once

#include <Eigen/Core>

#include "sim/files/csv.h"
#include "sim/files/table.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording.h"
#include "slam/observation.h"

namespace sim::recording {

/// The rows of a file, one after another, with stamps from 0 to 9e18 ns that increase from row to row. All
/// members throw FileError.
class StampedRows {
 public:
  /// epoch: the file's stamps, in column 1 and in ns, minus the stamps returned by stamp().
  explicit StampedRows(files::CsvReader csv, slam::Stamp epoch = slam::Stamp{0})
      : csv_(std::move(csv)), epoch_(epoch) {
    advance();
  }
  StampedRows(const StampedRows&) = delete;
  StampedRows& operator=(const StampedRows&) = delete;

  /// Returns the stamp of the current row, or nothing after the last.
  const std::optional<slam::Stamp>& stamp() const { return stamp_; }
  const files::CsvReader& row() const { return csv_; }
  void advance();

 private:
  files::CsvReader csv_;
  slam::Stamp epoch_;
  std::optional<slam::Stamp> stamp_;
};

/// The robot's own knowledge of its motion at a frame, in the folder mav0/<name>. The folder has rows
/// for the frames that have this motion, and no data.csv if there are none.
struct MotionSource {
  std::string name, comment;  ///< comment: for sensor.yaml
  std::string header;         ///< header of data.csv
  bool (*in)(const slam::Observation& o);
  std::string (*fields)(
      const slam::Observation& o);  ///< fields of a row after its stamp; they read back bit for bit
  /// Reads a row into the observation of its stamp. Throws FileError.
  void (*read)(const files::Row& row, slam::Observation& o);
};

/// Returns plan0, legs0 and command0. plan0 has a sensor.yaml even without a plan: it contains the start.
const std::array<MotionSource, 3>& motion_sources();

/// Returns the fields of a row of kCorrectionColumns, each after a comma.
std::string correction_fields(const score::StepCorrection& step);

/// Returns a reading in an IMU's row, by default fields 1 to 6. Throws FileError if no sensor can measure it.
Eigen::Vector3d angular_rate(const files::Row& row,
                             const std::vector<files::Column>& columns = {{1}, {2}, {3}});  ///< rad/s
Eigen::Vector3d acceleration(const files::Row& row,
                             const std::vector<files::Column>& columns = {{4}, {5}, {6}});  ///< m/s²

/// The recorded form of the readings of one kind of rig sensor.
struct RigFormat {
  std::string_view type, comment;  ///< for sensor.yaml
  std::string_view ending;  ///< file name ending of a reading in data/; empty: the rows have the readings
  int image_type = -1;      ///< OpenCV type
  std::string_view image_name = {};
};
/// Returns the recorded form of a kind of sensor.
const RigFormat& format_of(rig::Kind kind);

/// Reads the setup of a recording. Throws FileError.
RecordingSetup read_setup(const fs::path& folder, const Manifest& manifest);

/// Returns the head camera as a sensor of the rig.
rig::RigSensor head_camera(const RecordingSetup& setup);

/// Returns the points of a sweep as little-endian records of 20 bytes: x, y, z (m) and intensity as float32,
/// and the time since the sweep's stamp (ns) as int32.
std::string lidar_bytes(const std::vector<slam::LidarPoint>& points);
/// Returns the points of lidar_bytes(). Throws FileError if a record is incomplete or a number not finite.
std::vector<slam::LidarPoint> read_lidar(const fs::path& file, std::string_view bytes);

/// Reads the image or the points of a camera's or lidar's reading from the file with that name. Throws
/// FileError unless the file matches the folder's manifest and an image has the sensor's size.
slam::RigReading read_rig_file(const fs::path& folder, const Manifest& manifest, const rig::RigSensor& sensor,
                               const std::string& name);

/// A sensor of the robot's body, in the folder mav0/<name>.
struct BodySensor {
  std::string name;
  std::string type, comment;                                       ///< for sensor.yaml
  std::string (*yaml)(const std::vector<std::string>& joints);     ///< more lines of sensor.yaml
  std::string (*columns)(const std::vector<std::string>& joints);  ///< titles of data.csv, each after a comma
  std::string (*values)(const BodyReading& reading);               ///< fields of a row, each after a comma
  void (*read)(const files::CsvReader& row, BodyReading& reading);  ///< sets these values
};

/// Returns all body sensors, in the order of the manifest.
const std::vector<BodySensor>& body_sensors();

}  // namespace sim::recording

namespace sim::recording::recording_format {

inline const std::string kBody = "mav0/body.yaml";
/// The name of the sensor whose readings are the true motion of the chest IMU.
inline const std::string kMotion = "state_groundtruth_estimate0";
inline const std::string kFrames = "frames.csv";

/// Returns the name of a sensor's file, for cam0, imu0, plan0, the body or the rig.
inline std::string sensor_file(const std::string& sensor) { return "mav0/" + sensor + "/sensor.yaml"; }
inline std::string sensor_rows(const std::string& sensor) { return "mav0/" + sensor + "/data.csv"; }
inline std::string sensor_data(const std::string& sensor) { return "mav0/" + sensor + "/data/"; }

inline const std::string kStampColumn = "#timestamp [ns]";
inline const std::string kCameraHeader = kStampColumn + ",filename";
/// The rig's cameras and lidars; last column: stamp of the observation that has the reading.
inline const std::string kRigHeader = kCameraHeader + ",frame [ns]";
inline const std::string kImuHeader = kStampColumn +
                                      ",w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1]"
                                      ",a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]";
inline const std::string kPlanHeader = kStampColumn + "," + files::pose_columns("PC") +
                                       ",v_PC_C_x [m s^-1],v_PC_C_y [m s^-1],v_PC_C_z [m s^-1]"
                                       ",w_PC_C_x [rad s^-1],w_PC_C_y [rad s^-1],w_PC_C_z [rad s^-1]"
                                       ",support [],p_CF_x [m],p_CF_y [m],p_CF_z [m]";
inline const std::string kLegHeader = kStampColumn + "," + files::pose_columns("OC") +
                                      ",p_CS_x [m],p_CS_y [m],p_CS_z [m]," + files::pose_columns("CG");
inline const std::string kMotionHeader =
    "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
    "v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], "
    "b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]";
/// A truth file and the titles of its columns.
struct Table {
  std::string file, header;
};
inline const Table kTrueCamera{"truth/camera.csv", kStampColumn + "," + files::pose_columns("WC")},
    kTrueWaist{"truth/waist.csv", kStampColumn + "," + files::pose_columns("WB")},
    kPlannedWaist{"truth/waist_plan.csv", kStampColumn + "," + files::pose_columns("PB")},
    kDesiredWaist{"truth/waist_desired.csv", kTrueWaist.header};
inline const std::string kFootColumns =
    ",x [m],y [m],yaw [rad],plan_x [m],plan_y [m],plan_yaw [rad],planned_down,load [N]"
    ",creep_x [m],creep_y [m],creep_yaw [rad]";
inline const Table kFeet{"truth/feet.csv", kStampColumn + kFootColumns + kFootColumns};
/// The same for a robot with torque limits.
inline const std::string kFeetAndTorqueHeader = kFeet.header + ",torque_limited";
inline const std::string kCorrectionColumns =
    ",foot,desired_x [m],desired_y [m],desired_yaw [rad],expected_x [m],expected_y [m],expected_yaw [rad]"
    ",ahead [m],aside [m],turn [rad]";
inline const Table kCorrectedSteps{"truth/corrected_steps.csv", kStampColumn + kCorrectionColumns};
inline const std::string kTorques = "truth/torques.csv";
inline const Table kSurfaces{"truth/surfaces.csv",
                             "#kind," + files::pose_columns("WS") + ",size_1 [m],size_2 [m],size_3 [m]"};

/// The words for slam::Support, in the order of its values.
inline const std::array<std::string, 3> kSupport{"both", "left", "right"};

/// The words for score::Surface::Kind, in the order of its values.
inline const std::array<std::string, 7> kSurfaceKinds{"plane",     "box",     "sphere",  "cylinder",
                                                      "ellipsoid", "capsule", "triangle"};

}  // namespace sim::recording::recording_format
