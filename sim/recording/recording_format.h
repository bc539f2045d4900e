// The names and column titles of a recording's files, for its writer and its readers.
#pragma once

#include <array>
#include <string>

#include "sim/files/csv.h"
#include "slam/observation.h"

namespace sim::recording::recording_format {

inline const std::string kBody = "mav0/body.yaml";
inline const std::string kCameraFolder = "mav0/cam0/data/";
inline const std::string kCameraSensor = "mav0/cam0/sensor.yaml";
inline const std::string kCameraRows = "mav0/cam0/data.csv";
inline const std::string kImuSensor = "mav0/imu0/sensor.yaml";
inline const std::string kImuRows = "mav0/imu0/data.csv";
inline const std::string kPlanSensor = "mav0/plan0/sensor.yaml";
inline const std::string kPlanRows = "mav0/plan0/data.csv";
inline const std::string kMotionSensor = "mav0/state_groundtruth_estimate0/sensor.yaml";
inline const std::string kMotionRows = "mav0/state_groundtruth_estimate0/data.csv";
inline const std::string kFrames = "frames.csv";
inline const std::string kTrueCamera = "truth/camera.csv";
inline const std::string kTrueWaist = "truth/waist.csv";
inline const std::string kPlannedWaist = "truth/waist_plan.csv";
inline const std::string kFeet = "truth/feet.csv";
inline const std::string kCorrectedSteps = "truth/corrected_steps.csv";
inline const std::string kSurfaces = "truth/surfaces.csv";

inline std::string body_sensor_file(const std::string& sensor) { return "mav0/" + sensor + "/sensor.yaml"; }
inline std::string body_sensor_rows(const std::string& sensor) { return "mav0/" + sensor + "/data.csv"; }

inline const std::string kStampColumn = "#timestamp [ns]";
inline const std::string kCameraHeader = kStampColumn + ",filename";
inline const std::string kGyroHeader =
    kStampColumn + ",w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1]";
inline const std::string kImuHeader = kGyroHeader + ",a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]";
inline const std::string kPlanHeader = kStampColumn + "," + files::pose_columns("PC") +
                                       ",v_PC_C_x [m s^-1],v_PC_C_y [m s^-1],v_PC_C_z [m s^-1]"
                                       ",w_PC_C_x [rad s^-1],w_PC_C_y [rad s^-1],w_PC_C_z [rad s^-1]"
                                       ",support [],p_CF_x [m],p_CF_y [m],p_CF_z [m]";
inline const std::string kPlanAndLegsHeader =
    kPlanHeader + "," + files::pose_columns("OC") + ",p_CS_x [m],p_CS_y [m],p_CS_z [m]";
inline const std::string kMotionHeader =
    "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
    "v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], "
    "b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]";
inline const std::string kTrueCameraHeader = kStampColumn + "," + files::pose_columns("WC");
inline const std::string kTrueWaistHeader = kStampColumn + "," + files::pose_columns("WB");
inline const std::string kPlannedWaistHeader = kStampColumn + "," + files::pose_columns("PB");
inline const std::string kFootColumns =
    ",x [m],y [m],yaw [rad],plan_x [m],plan_y [m],plan_yaw [rad],planned_down,load [N]"
    ",creep_x [m],creep_y [m],creep_yaw [rad]";
inline const std::string kFeetHeader = kStampColumn + kFootColumns + kFootColumns;
inline const std::string kCorrectedStepsHeader =
    kStampColumn +
    ",foot,desired_x [m],desired_y [m],desired_yaw [rad],expected_x [m],expected_y [m],expected_yaw [rad]"
    ",ahead [m],aside [m],turn [rad]";
inline const std::string kSurfacesHeader =
    "#kind," + files::pose_columns("WS") + ",size_1 [m],size_2 [m],size_3 [m]";

/// slam::Support in words, in the order of its values.
inline const std::array<std::string, 3> kSupport{"both", "left", "right"};

/// score::Surface::Kind in words, in the order of its values.
inline const std::array<std::string, 6> kSurfaceKinds{"plane",    "box",       "sphere",
                                                      "cylinder", "ellipsoid", "capsule"};

}  // namespace sim::recording::recording_format
